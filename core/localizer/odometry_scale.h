#pragma once

#include <optional>

#include "core/geometry/pose.h"

namespace dcloc {

struct OdometryScaleOptions {
  double prior_sigma = 0.02;  ///< of the factor, before anything is learned
  double min_sigma = 0.002;   ///< it is never known better: load and tyres change
  double distance_m = 20.0;   ///< between the poses that are compared
  double pose_sigma_m = 0.3;  ///< of each of them, until their comparisons tell it
  double prior_count = 4.0;   ///< of comparisons that this is worth
};

/// Learns by which factor the speed that the vehicle reports is too low: the radius of its tyres is
/// known to a percent or two. The way between two poses in the map is compared with the same way by
/// odometry; errors of the map and the mounts, which last, cancel. How good the poses are differs
/// from map to map, and shows in how much the comparisons vary.
class OdometryScale {
 public:
  explicit OdometryScale(const OdometryScaleOptions& options);

  /// What the reported speed is to be multiplied by, and the deviation of that.
  double factor() const { return factor_; }
  double sigma() const;

  /// The vehicle moved so by odometry, which was multiplied by factor().
  void OnMotion(const Pose3& T_from_to);

  /// It is believed to be here now.
  void OnPose(const Pose3& T_map_vehicle);

  /// Where it was is no longer believed.
  void OnJump() { T_map_begin_.reset(); }

 private:
  // Variance of a comparison over `distance_m`, after one that was off by `error`.
  double Noise(double error, double distance_m);

  OdometryScaleOptions options_;
  double factor_ = 1.0;
  double variance_;
  std::optional<Pose3> T_map_begin_;
  Pose3 T_begin_now_;  // by odometry
  double way_m_ = 0.0;
  // Squared errors over those that pose_sigma_m lets expect, and how many; older ones count less.
  double squared_error_ = 0.0;
  double count_ = 0.0;
};

}  // namespace dcloc
