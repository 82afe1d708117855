#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "client/datasets/fix_file.h"
#include "core/calibration/calibration.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/localizer/localizer.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "dcloc/v1/localization_service.pb.h"
#include "dcloc/v1/map_service.pb.h"

namespace dcloc::cli {

// Conversions between core's types and messages, on the client's side.

v1::Rig ToProto(const Rig& rig);
v1::PoseWithCovariance ToProto(const InitialPose& initial_pose);
v1::Scan ToProto(const Scan& scan, std::int64_t sequence_number);
v1::GeodeticAnchor ToProto(const GeodeticAnchor& anchor);

GeodeticAnchor FromProto(const v1::GeodeticAnchor& anchor);

/// Of a described radar, its id and beta alone.
RadarCalibration FromProto(const v1::SurveyedRadar& radar);

/// A GNSS fix with the position and heading of `pose` and their deviations; roll and pitch are left
/// out.
v1::GnssFix FixOf(const InitialPose& pose, const GeodeticAnchor& anchor);

v1::PositionFix ToProto(const StampedFix& fix);

/// What a server of ours answers to a scan of `rig`; without timings, map version and place on the
/// Earth.
v1::LocalizationResult ToProto(const Localization& localization, const Rig& rig,
                               std::int64_t sequence_number);
v1::FixUse ToProto(FixUse use);

/// The answer as the localizer returned it. DataLoss for a message that no dcloc server sends.
absl::StatusOr<Localization> FromProto(const v1::LocalizationResult& result);

}  // namespace dcloc::cli
