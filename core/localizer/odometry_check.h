#pragma once
#include <chrono>
#include <cmath>
#include <optional>
#include "core/localizer/ego_motion.h"
#include "core/posegraph/state_chain.h"
namespace dcloc {
template <int Dim>
class OdometryCheck {
 public:
  // since: motion since the last registration that was given
  void OnRegistration(Stamp stamp, const PoseEstimate<Dim>& T_map,
                      const PoseEstimate<Dim>& since_last, std::chrono::nanoseconds min_lag) {
    if (begin_) {
      odo_.covariance =
          ComposeCovariance<Dim>(odo_.covariance, since_last.pose, since_last.covariance);
      odo_.pose = odo_.pose * since_last.pose;
      if (stamp - stamp_ < min_lag) return;
      const Pose<Dim> pred = begin_->pose * odo_.pose;
      const Tangent<Dim> e = Log(pred.Inverse() * T_map.pose);
      // begin's covariance carried
      const TangentMatrix<Dim> own =
          T_map.covariance +
          ComposeCovariance<Dim>(begin_->covariance, odo_.pose, TangentMatrix<Dim>::Zero());
      constexpr int kT = Pose<Dim>::kDof - Dim;
      const double forget = 0.98;
      num_t_ = forget * num_t_ +
               std::min(e.template head<Dim>().squaredNorm(),
                        9.0 * (own + odo_.covariance).template topLeftCorner<Dim, Dim>().trace()) -
               own.template topLeftCorner<Dim, Dim>().trace();
      den_t_ = forget * den_t_ + odo_.covariance.template topLeftCorner<Dim, Dim>().trace();
      num_r_ =
          forget * num_r_ +
          std::min(e.template tail<kT>().squaredNorm(),
                   9.0 * (own + odo_.covariance).template bottomRightCorner<kT, kT>().trace()) -
          own.template bottomRightCorner<kT, kT>().trace();
      den_r_ = forget * den_r_ + odo_.covariance.template bottomRightCorner<kT, kT>().trace();
      n_ = forget * n_ + 1;
    }
    begin_ = T_map;
    odo_ = {};
    stamp_ = stamp;
  }
  void OnJump() { begin_.reset(); }
  double ScaleT() const { return Of(num_t_, den_t_); }
  double ScaleR() const { return Of(num_r_, den_r_); }

 private:
  double Of(double num, double den) const {
    const double prior = n_ > 0 ? 4.0 * den / n_ : 1.0;
    return std::clamp((num + prior) / (den + prior), 0.02, 9.0);
  }
  std::optional<PoseEstimate<Dim>> begin_;
  PoseEstimate<Dim> odo_;
  Stamp stamp_{};
  double num_t_ = 0, den_t_ = 0, num_r_ = 0, den_r_ = 0, n_ = 0;
};
}  // namespace dcloc
