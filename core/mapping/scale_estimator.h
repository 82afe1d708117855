#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/map/point_grid.h"
#include "core/map/radar_map.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"
#include "core/radar/static_points.h"

namespace dcloc {

struct ScaleEstimatorOptions {
  /// Landmarks that have another one nearer than this tell nothing: which of the two a return is
  /// of, the poses decide whose scale is asked for.
  double clearance_m = 1.0;
  double max_distance_m = 3.0;        ///< of a return from its landmark
  double max_squared_distance = 9.0;  ///< likewise, in squared deviations
  double landmark_sigma_m = 0.1;      ///< by which a landmark errs beyond its covariance
  double range_sigma_m = 0.15;        ///< of a return's slant range
  /// Of where the landmark is, beside what its returns during a visit say.
  double offset_sigma_m = 10.0;
  std::size_t min_return_count = 8;  ///< of a visit that counts
  double min_path_m = 10.0;          ///< likewise: what the returns were taken along
  /// A landmark that is seen again after this is visited anew: poses may err otherwise then.
  std::chrono::nanoseconds visit_gap = std::chrono::seconds(10);
  /// Deviation of what a visit says, beyond noise: what reflects is no point.
  double visit_sigma = 0.005;
  std::size_t min_visit_count = 50;  ///< fewer say nothing
};
std::span<const OptionField<ScaleEstimatorOptions>> FieldsOf(const ScaleEstimatorOptions& options);
absl::Status Validate(const ScaleEstimatorOptions& options);

/// By which share the poses of drives lie too near one another, from the slant ranges to the
/// landmarks of a map that was made at these poses. A scatterer comes nearer by less than the
/// vehicle moves, the more the higher it stands; how its squared range bends along the way is the
/// same at any height and at any distance aside (METHOD eq 70).
///
/// Returns are assigned to landmarks by the poses in question. So a map made anew at rescaled poses
/// says more of what is missing: the estimate is to be repeated.
class ScaleEstimator {
 public:
  /// `options` are valid. The map need not outlive it.
  explicit ScaleEstimator(const RadarMap& map, const ScaleEstimatorOptions& options = {});

  /// The static points of a scan of a planar radar, in the vehicle frame; the radar was at
  /// `T_vehicle_radar` (`MountAtStamp`). By ascending stamps within a drive.
  void Add(std::span<const RadarPoint> points, Stamp stamp, const Pose3& T_map_vehicle,
           const Pose3& T_vehicle_radar);

  /// The drive is over.
  void EndDrive();

  /// The share, and the variance of that. Nothing where too few landmarks were passed.
  std::optional<ScalarEstimate> Estimate() const;

 private:
  struct Landmark {
    Eigen::Vector2d p_map;
    Eigen::Matrix2d covariance_m2;
    double height_square_m2;
    bool stands_alone = false;
  };
  // Weighted sums of the products of (1, x, y, |(x, y)|^2, r^2).
  using Sums = Eigen::Matrix<double, 5, 5>;
  // A landmark, as long as it is seen without a gap.
  struct Visit {
    Sums sums = Sums::Zero();
    std::size_t return_count = 0;
    Stamp last_stamp;
    Eigen::Array2d min_m = Eigen::Array2d::Constant(1e300);
    Eigen::Array2d max_m = Eigen::Array2d::Constant(-1e300);
  };

  std::optional<std::uint32_t> LandmarkOf(const Eigen::Vector2d& p_map,
                                          const Eigen::Matrix2d& covariance_m2,
                                          const Eigen::Vector2d& slant_per_m) const;
  void Close(const Visit& visit);

  ScaleEstimatorOptions options_;
  std::vector<Landmark> landmarks_;
  PointGrid grid_;
  std::map<std::uint32_t, Visit>
      visits_;                        // by landmark, in one order: sums are the same to the bit
  std::vector<ScalarEstimate> told_;  // by visits that are over: twice the share
};

}  // namespace dcloc
