#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/passes/placed_pass.h"
#include "core/radar/scan.h"

namespace dcloc {

struct PassTrackOptions {
  double knot_spacing_m = 10.0;  ///< of the way, from one estimated pose to the next
  double pose_sigma_m = 0.3;     ///< of the localizer's poses, which may all err alike
  double pose_sigma_rad = 0.02;  ///< likewise of their yaw
  // Likewise of the poses beyond the map: by default only odometry says where they are.
  double beyond_sigma_m = std::numeric_limits<double>::infinity();
  double beyond_sigma_rad = std::numeric_limits<double>::infinity();
  double drift_m = 0.004;               ///< of odometry, after 1 m; it grows by the root of the way
  double drift_rad = 0.0002;            ///< likewise of its yaw
  double scale_sigma = 0.02;            ///< of odometry, constant over the pass
  double yaw_rate_sigma_radps = 0.003;  ///< likewise
};

/// What something says of one pose: the sum of squares x^T information x - 2 x^T pull, where x is
/// the step of the pose in the tangent space on the right.
struct PosePull {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
};

/// The poses of those scans of a pass that count, joined by its odometry: a pose graph of knots
/// along the way, with the odometry's scale and yaw-rate bias. Between knots the poses follow
/// odometry.
class PassTrack {
 public:
  /// Begins with the poses of `pass`, smoothed by its odometry.
  PassTrack(const PlacedPass& pass, const PassTrackOptions& options);

  /// The scans that count, by their number in the pass, and their poses.
  const std::vector<std::size_t>& scans() const { return scans_; }
  const std::vector<Pose2>& T_map_vehicles() const { return T_map_vehicles_; }

  /// One step of Gauss-Newton: `pulls` are of the scans that count, at their present poses.
  void Move(std::span<const PosePull> pulls);

 private:
  /// The stretch from one knot to the next.
  struct Edge {
    Pose2 T_from_to;  ///< by odometry
    double length_m = 0.0;
    double duration_s = 0.0;
  };

  void PlaceScans();

  PassTrackOptions options_;
  std::vector<std::size_t> scans_;
  std::vector<Pose2> T_start_vehicles_;  // by odometry
  std::vector<std::size_t> knot_of_;     // of each scan: the last knot that is not after it
  std::vector<double> fraction_;         // of the way from that knot to the next one
  std::vector<std::size_t> knot_scans_;  // index into scans_
  std::vector<Pose2> given_;             // poses of the scans at knots
  std::vector<Eigen::Matrix3d> given_weights_;
  std::vector<Edge> edges_;
  std::vector<Pose2> knots_;
  std::vector<Pose2> T_map_vehicles_;
  double scale_ = 0.0;
  double yaw_rate_bias_radps_ = 0.0;
};

}  // namespace dcloc
