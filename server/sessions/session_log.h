#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/convert/answer.h"
#include "server/sessions/health_watch.h"
#include "server/sessions/session_info.h"

/// The log lines of a session.
namespace dcloc::server {

void LogOpened(const SessionInfo& info, std::size_t radar_count);
/// It goes on from a ticket of session `before`.
void LogGoesOn(const SessionInfo& info, const std::string& before);
/// A new session begins instead.
void LogTicketNotTaken(const SessionInfo& info, TicketUse use, const std::string& key_id);
void LogMoved(const SessionInfo& info, std::int64_t to_version);
void LogClosed(const SessionInfo& info);

/// For debugging: one line a scan. `encoding` is what making the answer's message took.
void LogLocalized(const SessionInfo& info, std::int64_t sequence_number, const LocalizedScan& scan,
                  std::chrono::nanoseconds encoding);
void LogRejected(const SessionInfo& info, std::int64_t sequence_number, const absl::Status& status);

/// The residuals of registrations contradict the radar's `beta_s`.
void LogBetaContradicted(const SessionInfo& info, const std::string& radar_id,
                         const BetaCheck& beta);

/// A source of `rig`'s vehicle was set aside, with the reason, or taken back.
void LogSource(const SessionInfo& info, const Rig& rig, const SourceChange& change);

/// The pose has jumped; the last jump's size.
void LogReset(const SessionInfo& info, const PoseResets& resets);

}  // namespace dcloc::server
