#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// What became of the ticket of an `open`; numbers as on the wire.
enum class TicketUse {
  kNone,
  kAccepted,
  kNotOffered,
  kMalformed,
  kUnknownKey,
  kForged,
  kForeign,
  kExpired,
  kOtherMapVersion,
  kStale,
  kUnusable,
};
inline constexpr std::array<const char*, 11> kTicketUseNames = {
    "none",    "accepted", "not_offered",       "malformed", "unknown_key", "forged",
    "foreign", "expired",  "other_map_version", "stale",     "unusable"};

constexpr const char* NameOf(TicketUse use) {
  return kTicketUseNames[static_cast<std::size_t>(use)];
}

/// What a client is told of its session when it is open.
struct OpenedSession {
  std::string session_id;
  std::string map_name;
  std::int64_t map_version = 0;
  std::optional<GeodeticAnchor> anchor;  ///< of the map
  std::string resume_token;              ///< a secret; empty unless it is resumable
  bool resumed = false;
  std::optional<std::int64_t> last_sequence_number;  ///< the highest one localized
  int answer_history_count = 0;
  std::chrono::nanoseconds detached_timeout{};  ///< zero unless it is resumable
  TicketUse ticket_use = TicketUse::kNone;
  std::int64_t epoch = 1;
  std::chrono::nanoseconds ticket_interval{};  ///< zero where there are no tickets
};

namespace convert {

/// Of sessions; one a second would need 285 million years.
inline constexpr std::int64_t kMaxEpoch = std::int64_t{1} << 53;

/// An `open` request, checked as far as possible without the map.
struct SessionRequest {
  std::string vehicle_id;
  std::string map_name;
  std::int64_t map_version = 0;  ///< 0: the active one
  Rig rig;
  LocalizerOptions options;
  std::int64_t epoch = 0;  ///< the highest one that the client has seen
};

absl::StatusOr<SessionRequest> FromProto(const v1::OpenSession& message);

/// The initial pose in a map with that anchor, if any; none when the client gave none.
/// FailedPrecondition for a GNSS fix in a map without an anchor.
absl::StatusOr<std::optional<InitialPose>> InitialPoseFromProto(
    const v1::OpenSession& message, const std::optional<GeodeticAnchor>& anchor);

void ToProto(const OpenedSession& session, v1::SessionOpened* message);

}  // namespace convert
}  // namespace dcloc::server
