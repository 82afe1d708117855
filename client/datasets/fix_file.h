#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/radar/stamp.h"
#include "core/relocalization/gnss_prior.h"
#include "core/relocalization/initial_pose.h"

namespace dcloc {

/// What something else than radar says of the vehicle's place in the map frame.
struct MapFix {
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();
  double horizontal_sigma_m = 0.0;  ///< along each horizontal axis
  double vertical_sigma_m = 0.0;
  std::optional<double> yaw_deg;  ///< of the vehicle, counter-clockwise from the map's x axis
  double yaw_sigma_deg = 0.0;     ///< where there is a yaw
};

/// The fix as a pose: level, and with a yaw of any value where the fix has none.
InitialPose PoseOf(const MapFix& fix);

/// A position fix of a drive.
struct StampedFix {
  Stamp stamp;
  std::variant<GnssFix, MapFix> position;
};

/// Reads fixes from a CSV file, by ascending stamp. The header decides which kind they are, and may
/// have its columns in any order:
///   stamp_ns,latitude_deg,longitude_deg,height_m,horizontal_sigma_m,vertical_sigma_m
///     [,heading_deg,heading_sigma_deg]
///   stamp_ns,x_m,y_m,z_m,horizontal_sigma_m,vertical_sigma_m[,yaw_deg,yaw_sigma_deg]
/// The last two may be empty in a row. Errors name the path, the line, the column, the value and
/// the bound: NotFound, DataLoss.
absl::StatusOr<std::vector<StampedFix>> ReadFixes(const std::filesystem::path& path);

/// Writes such a file; all fixes are of the first one's kind. Errors name the path.
absl::Status WriteFixes(const std::filesystem::path& path, const std::vector<StampedFix>& fixes);

}  // namespace dcloc
