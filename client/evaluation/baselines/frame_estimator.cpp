#include <cmath>

#include "client/evaluation/baselines/estimator.h"
#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

// Further than this from the prediction no registration can be right: after a prior of a metre or
// two, and dead reckoning of a few seconds.
constexpr double kMaxStep_m = 5.0;
constexpr double kMaxTurn_rad = 0.26;

class FrameEstimator final : public Estimator {
 public:
  explicit FrameEstimator(const PoseEstimate<2>& initial) : now_{.T_local_vehicle = initial.pose} {}

  void Advance(const Motion& motion) override {
    const Pose2 T_from_to = Flatten(motion.T_from_to);
    now_.T_local_vehicle = now_.T_local_vehicle * T_from_to;
    if (!now_.covariance) return;
    now_.covariance =
        ComposeCovariance<2>(*now_.covariance, T_from_to, FlattenCovariance(motion.covariance));
  }

  std::optional<double> Correct(const std::optional<PlanarFit>& fit,
                                std::span<const RadarPoint> /*submap*/) override {
    if (!fit) return std::nullopt;
    const Pose2 T_predicted_found = now_.T_local_vehicle.Inverse() * fit->T_local_vehicle;
    if (T_predicted_found.translation_m.norm() > kMaxStep_m ||
        std::abs(T_predicted_found.yaw_rad) > kMaxTurn_rad) {
      return std::nullopt;
    }
    now_ = {.T_local_vehicle = fit->T_local_vehicle, .covariance = fit->covariance};
    return 0.0;
  }

  Estimate Now() const override { return now_; }

  void ChangeFrame(const Pose2& T_new_old) override {
    now_.T_local_vehicle = T_new_old * now_.T_local_vehicle;
  }

 private:
  Estimate now_;
};

}  // namespace

std::unique_ptr<Estimator> MakeFrameEstimator(const PoseEstimate<2>& initial) {
  return std::make_unique<FrameEstimator>(initial);
}

}  // namespace dcloc
