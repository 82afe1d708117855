#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>

#include "client/evaluation/baselines/planar_registration.h"
#include "core/localizer/localizer_options.h"
#include "core/odometry/motion.h"
#include "core/posegraph/pose_graph.h"

namespace dcloc {

/// Estimates the pose from ego-motion and registrations, in the plane of a local map frame.
class Estimator {
 public:
  /// A pose; the covariance, in the tangent space on the right, is absent where it is not known.
  struct Estimate {
    Pose2 T_local_vehicle;
    std::optional<Eigen::Matrix3d> covariance;
  };

  virtual ~Estimator() = default;

  /// The vehicle moved since the last call.
  virtual void Advance(const Motion& motion) = 0;

  /// A registration was tried on `submap`. Returns the squared Mahalanobis distance of its test, 0
  /// without a test; nothing if it is rejected.
  virtual std::optional<double> Correct(const std::optional<PlanarFit>& fit,
                                        std::span<const RadarPoint> submap) = 0;

  virtual Estimate Now() const = 0;

  /// Expresses everything in another local frame.
  virtual void ChangeFrame(const Pose2& T_new_old) = 0;
};

/// No filter: the last registration, moved on by ego-motion.
std::unique_ptr<Estimator> MakeFrameEstimator(const PoseEstimate<2>& initial);

/// The paper's truncated pose graph (III-E) over the last n states: odometry edges are
/// registrations between consecutive sub-maps, loop edges are those to the map. Both are cut when
/// their squared distance to the ego-motion's prediction from the previous raw match, under their
/// own covariance alone, exceeds the 95 % chi-square quantile.
std::unique_ptr<Estimator> MakeGraphEstimator(const PoseEstimate<2>& initial,
                                              const LocalizerOptions& options);

}  // namespace dcloc
