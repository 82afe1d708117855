#pragma once

#include <Eigen/Core>

#include "core/odometry/scalar_estimate.h"

namespace dcloc {

/// How a speed [m/s] or a yaw rate [rad/s] that is reported late may change.
struct LateSignalNoise {
  double unknown_sigma = 0.0;  ///< of the signal, before anything is known
  double change_sigma = 0.0;   ///< of its change in a second, likewise
  double change_walk = 0.0;    ///< of what a second adds to its change
  double offset_sigma = 0.0;   ///< of what the two sources differ by, at first
  double offset_walk = 0.0;    ///< of what a second adds to that
};

/// One signal that a source reports late, and another one measures at once, less exactly and with
/// an offset of its own: a Kalman filter over the signal, its change, and the offset (METHOD eq
/// 46). The late source says what the signal was, the other one how it went on.
class LateSignal {
 public:
  explicit LateSignal(const LateSignalNoise& noise);

  /// `duration_s` seconds pass.
  void Advance(double duration_s);

  /// The signal's value `delay_s` before now was `reading`; a negative delay is in the future.
  void OnLate(const ScalarEstimate& reading, double delay_s);

  /// The signal's value now, plus the offset, is `reading`.
  void OnPrompt(const ScalarEstimate& reading);

  ScalarEstimate now() const { return {state_(0), covariance_(0, 0)}; }

 private:
  void KalmanUpdate(const Eigen::RowVector3d& row, double value, double variance);

  LateSignalNoise noise_;
  Eigen::Vector3d state_ = Eigen::Vector3d::Zero();  // signal, its change in a second, offset
  Eigen::Matrix3d covariance_;
};

}  // namespace dcloc
