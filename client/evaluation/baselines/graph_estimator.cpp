#include <Eigen/Cholesky>
#include <vector>

#include "client/evaluation/baselines/descriptor_registration.h"
#include "client/evaluation/baselines/estimator.h"
#include "client/evaluation/baselines/window_graph.h"
#include "core/geometry/covariance.h"
#include "core/registration/gicp.h"

namespace dcloc {
namespace {

constexpr std::size_t kMinPoints = 10;

// Squared Mahalanobis distance (eq 18-19) of what was measured to what was predicted.
double SquaredDistance(const Pose2& predicted, const PoseEstimate<2>& measured) {
  const Eigen::Vector3d apart = Log(predicted.Inverse() * measured.pose);
  return apart.dot(measured.covariance.ldlt().solve(apart));
}

class GraphEstimator final : public Estimator {
 public:
  GraphEstimator(const PoseEstimate<2>& initial, const LocalizerOptions& options)
      : gicp_(options.matcher.gicp),
        max_squared_distance_(options.pose_graph.max_squared_distance_planar),
        graph_(options.pose_graph.window) {
    graph_.Reset(initial);
  }

  void Advance(const Motion& motion) override {
    since_state_ = Compose(since_state_, motion);
    if (raw_) *raw_ = *raw_ * Flatten(motion.T_from_to);
  }

  std::optional<double> Correct(const std::optional<PlanarFit>& fit,
                                std::span<const RadarPoint> submap) override {
    std::vector<GaussianPoint<2>> points = InPlane(submap);
    graph_.AddState(OdometryEdge(points));
    since_state_ = {};
    previous_ = LocalMap<2>({}, points);
    std::optional<double> distance;
    if (fit && fit->covariance) {
      const PoseEstimate<2> loop{.pose = fit->T_local_vehicle, .covariance = *fit->covariance};
      distance = raw_ ? SquaredDistance(*raw_, loop) : 0.0;
      if (*distance <= max_squared_distance_) {
        graph_.AddAbsolutePose(loop);
      } else {
        distance.reset();
      }
      raw_ = fit->T_local_vehicle;
    }
    graph_.Solve();
    return distance;
  }

  Estimate Now() const override {
    const PoseEstimate<2>& newest = graph_.Newest();
    const Pose2 motion = Flatten(since_state_.T_from_to);
    return {.T_local_vehicle = newest.pose * motion,
            .covariance = ComposeCovariance<2>(newest.covariance, motion,
                                               FlattenCovariance(since_state_.covariance))};
  }

  void ChangeFrame(const Pose2& T_new_old) override {
    graph_.ChangeFrame(T_new_old);
    if (raw_) *raw_ = T_new_old * *raw_;
  }

 private:
  // The registration of this sub-map in the previous one; ego-motion where that is cut or fails.
  PoseEstimate<2> OdometryEdge(std::span<const GaussianPoint<2>> points) const {
    PoseEstimate<2> predicted{.pose = Flatten(since_state_.T_from_to),
                              .covariance = FlattenCovariance(since_state_.covariance)};
    if (previous_.empty() || points.size() < kMinPoints) return predicted;
    const Registration<2> registration = RegisterGicp<2>(points, previous_, predicted.pose, gicp_);
    if (!registration.converged) return predicted;
    PoseEstimate<2> measured{.pose = registration.T_local_vehicle,
                             .covariance = registration.covariance};
    return SquaredDistance(predicted.pose, measured) <= max_squared_distance_ ? measured
                                                                              : predicted;
  }

  GicpOptions gicp_;
  double max_squared_distance_;
  WindowGraph graph_;
  Motion since_state_;
  LocalMap<2> previous_;      // the last state's sub-map, in its own vehicle frame
  std::optional<Pose2> raw_;  // the last fit, accepted or not, carried on by ego-motion
};

}  // namespace

std::unique_ptr<Estimator> MakeGraphEstimator(const PoseEstimate<2>& initial,
                                              const LocalizerOptions& options) {
  return std::make_unique<GraphEstimator>(initial, options);
}

}  // namespace dcloc
