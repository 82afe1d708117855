#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/odometry/late_signal.h"
#include "core/odometry/motion.h"
#include "core/odometry/odometry_delay_estimator.h"
#include "core/odometry/source_monitor.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"

namespace dcloc {

struct LateOdometryOptions {
  OdometryDelayOptions delay;
  // All are standard deviations. A walk is that of what one second adds.
  double acceleration_sigma_mps2 = 1.5;         ///< of the vehicle's acceleration, at first
  double acceleration_walk_mps2 = 2.5;          ///< of its change
  double yaw_acceleration_sigma_radps2 = 0.25;  ///< of the vehicle's yaw acceleration, at first
  double yaw_acceleration_walk_radps2 = 0.3;    ///< of its change
  /// Of the speed when a delay is accepted: so wide that the first reports alone decide.
  double first_speed_sigma_mps = kUnknownSpeedSigma_mps;
  double first_yaw_rate_sigma_radps = 1.0;      ///< of the yaw rate, likewise
  double doppler_speed_sigma_mps = 0.06;        ///< noise of Doppler's speed in one moment
  double doppler_yaw_rate_sigma_radps = 0.015;  ///< noise of Doppler's yaw rate in one moment
  double offset_speed_sigma_mps = 0.3;  ///< of Doppler's constant offset from the reported speed
  double offset_yaw_rate_sigma_radps = 0.03;  ///< of that from the reported yaw rate
  double offset_speed_walk_mps = 0.03;        ///< of the change of the speed's offset
  double offset_yaw_rate_walk_radps = 0.002;  ///< of the change of the yaw rate's offset
};
std::span<const OptionField<LateOdometryOptions>> FieldsOf(const LateOdometryOptions& options);
absl::Status Validate(const LateOdometryOptions& options);

/// Finds by how much the reported velocity is late, and brings it to the present: it says what the
/// vehicle did then, and Doppler how that went on.
class LateOdometry {
 public:
  explicit LateOdometry(const LateOdometryOptions& options);

  /// As OdometryDelayEstimator::Restore.
  void Restore(const ScalarEstimate& delay_s) { estimator_.Restore(delay_s); }

  /// The vehicle reports this at `stamp`, which is not before the last one.
  void OnReported(Stamp stamp, const EgoVelocity& reported);
  /// Doppler that is sound says this of `stamp`.
  void OnDoppler(Stamp stamp, const EgoVelocity& doppler);

  /// By how many seconds the reported velocity is late; nothing while no delay is accepted.
  const std::optional<ScalarEstimate>& delay_s() const { return estimator_.delay_s(); }

  /// `reported`, which has a covariance, as an estimate of now by itself: less certain by what the
  /// vehicle may have done within the delay. As it is, while no delay is accepted.
  EgoVelocity WithDelayUncertainty(const EgoVelocity& reported) const;

  /// `reported` at `stamp` brought to the present, with what Doppler says; `doppler` is null where
  /// that is not sound. A reported signal whose source is not in `sound` is left as it is, and both
  /// are while no delay is accepted.
  EgoVelocity ExtrapolatedToNow(Stamp stamp, const EgoVelocity& reported,
                                const EgoVelocity* doppler, const OdometrySources& sound);

  /// The motion between the last two moments that were brought to the present (METHOD eq 47);
  /// nothing while no delay is accepted, or where a signal is not sound.
  const std::optional<Pose3>& T_previous_now() const { return T_previous_now_; }

 private:
  void Reset();
  LateSignalNoise SpeedNoise() const;
  LateSignalNoise YawRateNoise() const;
  void Move(const EgoVelocity& reported, const EgoVelocity& now, std::chrono::nanoseconds duration);

  LateOdometryOptions options_;
  OdometryDelayEstimator estimator_;
  std::optional<LateSignal> speed_, yaw_rate_;  // while a delay is accepted
  std::optional<Stamp> advanced_, doppler_;
  std::optional<EgoVelocity> reported_;  // at `advanced_`
  Pose3 T_late_now_;                     // from where the vehicle reports to be, at `advanced_`
  std::optional<Pose3> T_previous_now_;
};

}  // namespace dcloc
