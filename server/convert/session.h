#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "core/localizer/localizer.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server::convert {

/// What an `open` asks for, checked as far as that goes without the map.
struct SessionRequest {
  std::string vehicle_id;
  std::string map_name;
  std::int64_t map_version = 0;  ///< 0: the active one
  Rig rig;
  LocalizerOptions options;
};

absl::StatusOr<SessionRequest> FromProto(const v1::OpenSession& message);

/// The initial pose in a map with that anchor, if any; none when the client gave none.
/// FailedPrecondition for a GNSS fix in a map without an anchor.
absl::StatusOr<std::optional<InitialPose>> InitialPoseFromProto(
    const v1::OpenSession& message, const std::optional<GeodeticAnchor>& anchor);

/// Everything of the answer but the sequence number, the version, the timings and the geodetic
/// pose.
void ToProto(const Localization& localization, v1::LocalizationResult* message);

v1::LocalizationState ToProto(LocalizationState state);

}  // namespace dcloc::server::convert
