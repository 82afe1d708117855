#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/localizer/localizer_snapshot.h"

namespace dcloc::server {

/// What another server goes on with a session from.
struct TicketContent {
  std::int64_t map_version = 0;
  std::string map_sha256;  ///< of that version's file
  std::int64_t epoch = 0;
  std::int64_t last_sequence_number = 0;  ///< the snapshot's scan
  std::string session_id;                 ///< for the log
  LocalizerSnapshot snapshot;
};

/// The content as bytes, at most `max_size` of them: what was learned of single radars is left out
/// where there are too many. ResourceExhausted where the rest is too long, too.
absl::StatusOr<std::string> WriteTicketContent(const TicketContent& content, std::size_t max_size);

/// The inverse. InvalidArgument names what is no ticket's content, or not within its bounds.
absl::StatusOr<TicketContent> ReadTicketContent(absl::string_view bytes);

}  // namespace dcloc::server
