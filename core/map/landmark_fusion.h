#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// One static return in the map, relative to the local origin (positions of the order of 1e6 m).
struct MapReturn {
  Eigen::Vector3d position_m;
  std::array<float, 6> covariance_m2;  ///< measurement noise: xx, xy, xz, yy, yz, zz
  float rcs_dbsm;
  std::uint32_t scan;                               ///< number of its scan
  std::array<float, 2> slant_per_m = {0.0F, 0.0F};  ///< RadarPoint::slant_per_m, turned
};

/// A landmark: the fused returns of one scatterer.
struct Landmark {
  Eigen::Vector3d position_m;
  /// Of a further return's position, without that return's own measurement noise.
  Eigen::Matrix3d covariance_m2;
  float rcs_dbsm;
  std::uint32_t scan_count;
  std::uint32_t pass_count;
  double height_m = 0.0;  ///< over the radars that saw it, where they are planar
};

struct FusionOptions {
  double cell_m = 0.4;     ///< noiseless returns within a circle of this diameter are one landmark
  int min_scan_count = 2;  ///< landmarks seen by fewer scans are clutter
  /// Prior deviation of the square of a landmark's height over planar radars; 0: every landmark is
  /// taken to be as high as the radar.
  double height_square_sigma_m2 = 25.0;
};
std::span<const OptionField<FusionOptions>> FieldsOf(const FusionOptions& options);

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const FusionOptions& options);

/// Fuses returns into landmarks. `returns` are ordered by scan, and `pass_of_scan[scan]` ascends.
/// Without `has_elevation` returns have x and y only, and their z is assumed.
///
/// Each return is a Gaussian: its measurement covariance plus the size of a scatterer. Starting
/// with the most certain return, a return that no landmark explains founds a new one. Then, in a
/// few rounds, every return joins the landmark that explains it best, and landmarks move to the
/// information-weighted mean of their returns. A landmark that ends up at another's place is
/// removed. Last, the height of each is fitted from how its slant ranges change with the range, and
/// its position is corrected for it. No grid decides which returns belong together, so nothing is
/// cut at cell borders. The result depends only on the returns and their order.
std::vector<Landmark> FuseLandmarks(std::span<const MapReturn> returns,
                                    std::span<const std::uint32_t> pass_of_scan, bool has_elevation,
                                    const FusionOptions& options);

}  // namespace dcloc
