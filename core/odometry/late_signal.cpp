#include "core/odometry/late_signal.h"

#include <cmath>

namespace dcloc {

LateSignal::LateSignal(const LateSignalNoise& noise)
    : noise_(noise),
      covariance_(Eigen::Vector3d(noise.unknown_sigma, noise.change_sigma, noise.offset_sigma)
                      .cwiseAbs2()
                      .asDiagonal()) {}

void LateSignal::Advance(double duration_s) {
  Eigen::Matrix3d by_state = Eigen::Matrix3d::Identity();
  by_state(0, 1) = duration_s;
  state_ = by_state * state_;
  covariance_ = by_state * covariance_ * by_state.transpose();
  // The change walks: it adds to the signal, in the mean over the time, by a half of it.
  const double change_variance = noise_.change_walk * noise_.change_walk * duration_s;
  covariance_(0, 0) += change_variance * duration_s * duration_s / 3.0;
  covariance_(0, 1) += change_variance * duration_s / 2.0;
  covariance_(1, 0) += change_variance * duration_s / 2.0;
  covariance_(1, 1) += change_variance;
  covariance_(2, 2) += noise_.offset_walk * noise_.offset_walk * duration_s;
}

void LateSignal::OnLate(const ScalarEstimate& reading, double delay_s) {
  // What the walk of the change made of the signal meanwhile.
  const double late_s = std::abs(delay_s);
  const double walked = noise_.change_walk * noise_.change_walk * late_s * late_s * late_s / 3.0;
  KalmanUpdate({1.0, -delay_s, 0.0}, reading.value, reading.variance + walked);
}

void LateSignal::OnPrompt(const ScalarEstimate& reading) {
  KalmanUpdate({1.0, 0.0, 1.0}, reading.value, reading.variance);
}

void LateSignal::KalmanUpdate(const Eigen::RowVector3d& row, double value, double variance) {
  const double spread = row * covariance_ * row.transpose() + variance;
  const Eigen::Vector3d gain = covariance_ * row.transpose() / spread;
  state_ += gain * (value - row * state_);
  const Eigen::Matrix3d keep = Eigen::Matrix3d::Identity() - gain * row;
  covariance_ = keep * covariance_ * keep.transpose() + variance * gain * gain.transpose();
}

}  // namespace dcloc
