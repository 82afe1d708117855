#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/convert/answer.h"
#include "server/sessions/health_watch.h"
#include "server/sessions/session_record.h"

/// The log lines of a session.
namespace dcloc::server {

void LogOpened(const SessionRecord& record, std::size_t radar_count);
/// It goes on from a ticket of session `before`.
void LogGoesOn(const SessionRecord& record, const std::string& before);
/// A new session begins instead.
void LogTicketNotTaken(const SessionRecord& record, TicketUse use, const std::string& key_id);
void LogMoved(const SessionRecord& record, std::int64_t to_version);
void LogClosed(const SessionRecord& record);

/// For debugging: one line a scan. `encoding` is what making the answer's message took.
void LogLocalized(const SessionRecord& record, std::int64_t sequence_number,
                  const LocalizedScan& scan, std::chrono::nanoseconds encoding);
void LogRejected(const SessionRecord& record, std::int64_t sequence_number,
                 const absl::Status& status);

/// The residuals of registrations contradict the radar's `beta_s`.
void LogBetaContradicted(const SessionRecord& record, const std::string& radar_id,
                         const BetaCheck& beta);

/// A source of `rig`'s vehicle was set aside, with the reason, or taken back.
void LogSource(const SessionRecord& record, const Rig& rig, const SourceChange& change);

/// The pose has jumped; the last jump's size.
void LogReset(const SessionRecord& record, const PoseResets& resets);

}  // namespace dcloc::server
