#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "client/rosbag/messages.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::node {

/// A satellite receiver's message as a position fix; the receiver's antenna is taken for the
/// vehicle's origin. `sigma_m` stands in for deviations that it does not tell; heights are taken
/// for twice as uncertain. FailedPrecondition while the receiver has no fix.
absl::StatusOr<v1::PositionFix> FixOf(const rosbag::SatelliteFix& message, double sigma_m);

/// A pose in the map that someone gives, as RViz does: `message` is a PoseWithCovarianceStamped.
/// Its covariance is made no narrower than 0.1 m and 0.6 degrees, since tools leave height, roll
/// and pitch 0. InvalidArgument for another frame than `map_frame`, DataLoss for a pose that is
/// none.
absl::StatusOr<v1::PoseWithCovariance> PoseOf(const rosbag::Motion& message,
                                              const std::string& map_frame);

}  // namespace dcloc::node
