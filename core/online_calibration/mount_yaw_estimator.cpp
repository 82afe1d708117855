#include "core/online_calibration/mount_yaw_estimator.h"

#include <algorithm>
#include <cmath>

#include "core/radar/directions.h"
#include "core/radar/measurement.h"

namespace dcloc {
namespace {

constexpr double kTrialStep_rad = 1.0 * kRadPerDeg;
// A mount is first looked for where it is expected, then anywhere.
constexpr double kNear_rad = 3.0 * kRadPerDeg;
constexpr double kAnywhere_rad = 95.0 * kRadPerDeg;
constexpr double kMinRangeRate_mps = 1.0;  // of a target that tells the speed
constexpr double kMaxSpeedFactor = 2.0;

using Target = MountYawTarget;

class Targets {
 public:
  Targets(const Scan& scan, const RadarModel& radar, const EgoVelocity& velocity, int max_count,
          MountYawWorkspace& targets)
      : targets_(targets),
        unambiguous_mps_(radar.unambiguous_range_rate_mps),
        lever_m_(radar.T_vehicle_radar.translation_m.head<2>().norm()) {
    const Eigen::Matrix3d R_vehicle_radar = radar.T_vehicle_radar.Rotation();
    const Eigen::Vector3d radar_mps =
        velocity.linear_mps + velocity.angular_radps.cross(radar.T_vehicle_radar.translation_m);
    const std::size_t count = std::min(scan.size(), static_cast<std::size_t>(max_count));
    targets_.clear();
    for (std::size_t k = 0; k < count; ++k) {
      const Measurement m = MeasurementAt(scan, k * scan.size() / count, radar);
      const Eigen::Vector3d u = R_vehicle_radar * LineOfSight(m.azimuth_rad, m.elevation_rad);
      const Eigen::Vector3d left = Eigen::Vector3d::UnitZ().cross(u);
      targets_.push_back({u.dot(radar_mps), left.dot(radar_mps), m.range_rate_mps,
                          m.range_rate_sigma_mps, m.azimuth_sigma_rad, DirectionOf(u)});
    }
  }

  // Of the direction in which the radar moves: a yaw rate may be wrong by as much as it is.
  double DirectionVariance(const EgoVelocity& velocity) const {
    const double known = velocity.covariance ? (*velocity.covariance)(5, 5) : 0.0;
    return (known + std::pow(velocity.angular_radps.z(), 2)) * lever_m_ * lever_m_ /
           velocity.linear_mps.head<2>().squaredNorm();
  }

  std::size_t size() const { return targets_.size(); }

  int CountInliers(double yaw_rad, double gate_mps) const {
    int count = 0;
    ForEachInlier(yaw_rad, gate_mps, [&](const Target&) { ++count; });
    return count;
  }

  int CountDirectionsOfInliers(double yaw_rad, double gate_mps) const {
    Directions directions;
    ForEachInlier(yaw_rad, gate_mps, [&](const Target& target) {
      directions.set(static_cast<std::size_t>(target.direction));
    });
    return static_cast<int>(directions.count());
  }

  struct Angle {
    double yaw_rad;
    int inlier_count;
  };

  // By which most targets are inliers; of several the one nearest to the expected one.
  Angle BestAngle(double expected_rad, double around_rad, const MountYawOptions& options) const {
    Angle best{.yaw_rad = expected_rad, .inlier_count = 0};
    const auto trials = static_cast<int>(around_rad / kTrialStep_rad);
    for (int i = -trials; i <= trials; ++i) {
      const double yaw_rad = expected_rad + i * kTrialStep_rad;
      const int count = CountInliers(yaw_rad, options.inlier_gate_mps);
      if (count > best.inlier_count ||
          (count == best.inlier_count &&
           std::abs(i * kTrialStep_rad) < std::abs(best.yaw_rad - expected_rad))) {
        best = {.yaw_rad = yaw_rad, .inlier_count = count};
      }
    }
    return best;
  }

  // What the speed is to be multiplied by for the targets to stand still, seen from a mount that is
  // turned by `yaw_rad`.
  double SpeedFactor(double yaw_rad) {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    const auto predicted_mps = [&](const Target& t) {
      return -(c * t.along_mps + s * t.across_mps);
    };
    const auto end = std::partition(targets_.begin(), targets_.end(), [&](const Target& t) {
      return std::abs(predicted_mps(t)) >= kMinRangeRate_mps;
    });
    if (end == targets_.begin()) return 1.0;
    const auto ratio = [&](const Target& t) {
      const double expected_mps = predicted_mps(t);
      return 1.0 + Residual(t, expected_mps) / expected_mps;
    };
    const auto middle = targets_.begin() + (end - targets_.begin()) / 2;
    std::nth_element(targets_.begin(), middle, end,
                     [&](const Target& a, const Target& b) { return ratio(a) < ratio(b); });
    return ratio(*middle);
  }

  void MultiplySpeed(double factor) {
    for (Target& t : targets_) {
      t.along_mps *= factor;
      t.across_mps *= factor;
    }
  }

  // One step of Gauss-Newton for the angle and the speed from the inliers at `yaw_rad`.
  ScalarEstimate Refine(double yaw_rad, const MountYawOptions& options) const {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    const double speed_sigma = options.speed_sigma_fraction;
    Eigen::Matrix2d normal =
        Eigen::Vector2d(1.0 / (kAnywhere_rad * kAnywhere_rad), 1.0 / (speed_sigma * speed_sigma))
            .asDiagonal();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (const Target& t : targets_) {
      const double predicted_mps = -(c * t.along_mps + s * t.across_mps);
      const double residual_mps = Residual(t, predicted_mps);
      if (std::abs(residual_mps) > options.inlier_gate_mps) continue;
      const double by_yaw = s * t.along_mps - c * t.across_mps;
      const Eigen::Vector2d row(by_yaw, predicted_mps);
      const double variance = t.sigma_mps * t.sigma_mps + std::pow(t.azimuth_sigma_rad * by_yaw, 2);
      normal += row * row.transpose() / variance;
      right += row * residual_mps / variance;
    }
    const Eigen::Matrix2d covariance = normal.inverse();
    return {yaw_rad + (covariance * right)(0), covariance(0, 0)};
  }

 private:
  template <typename Visit>
  void ForEachInlier(double yaw_rad, double gate_mps, const Visit& visit) const {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    for (const Target& t : targets_) {
      const double predicted_mps = -(c * t.along_mps + s * t.across_mps);
      if (std::abs(Residual(t, predicted_mps)) <= gate_mps) visit(t);
    }
  }

  double Residual(const Target& target, double predicted_mps) const {
    return UnfoldRangeRate(target.range_rate_mps, predicted_mps, unambiguous_mps_) - predicted_mps;
  }

  MountYawWorkspace& targets_;
  double unambiguous_mps_;
  double lever_m_;
};

}  // namespace

std::span<const OptionField<MountYawOptions>> FieldsOf(const MountYawOptions& /*options*/) {
  using O = MountYawOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_speed_mps", &O::min_speed_mps, 0.1, 1000},
      {"max_yaw_rate_radps", &O::max_yaw_rate_radps, 0, 10, "nothing is learned"},
      {"interval_ms", &O::interval, 0, 1e5, "each scan is a reading"},
      {"inlier_gate_mps", &O::inlier_gate_mps, 1e-6, 100},
      {"min_inlier_count", &O::min_inlier_count, 3, 10'000},
      {"min_inlier_fraction", &O::min_inlier_fraction, 0, 1, "the count alone decides"},
      {"min_direction_count", &O::min_direction_count, 0, kDirectionCount,
       "what one mover may have said counts, too"},
      {"max_target_count", &O::max_target_count, 3, 10'000},
      {"reading_sigma_rad", &O::reading_sigma_rad, 1e-9, 1},
      {"speed_sigma_fraction", &O::speed_sigma_fraction, 1e-9, 1},
      {"drift_sigma_rad", &O::drift_sigma_rad, 0, 1, "what was learned holds for ever"},
      {"outlier_sigmas", &O::outlier_sigmas, 1, 1000},
      {"knocked_readings", &O::knocked_readings, 1, 1000},
      {"outlier_span_ms", &O::outlier_span, 1, 1e5},
      {"knocked_spread_rad", &O::knocked_spread_rad, 1e-6, 3.2},
  };
  return kFields;
}

absl::Status Validate(const MountYawOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<ScalarEstimate> MountYawOfScan(const Scan& scan, const RadarModel& radar,
                                             const EgoVelocity& velocity,
                                             const MountYawTrial& trial,
                                             const MountYawOptions& options,
                                             MountYawWorkspace& workspace) {
  Targets targets(scan, radar, velocity, options.max_target_count, workspace);
  const auto is_enough = [&](int inlier_count) {
    return inlier_count >= options.min_inlier_count &&
           inlier_count >= options.min_inlier_fraction * static_cast<double>(targets.size());
  };
  auto [best_rad, most] = targets.BestAngle(trial.expected_rad, trial.around_rad, options);
  // Where another speed explains more than any mount, it is the speed that is wrong, or the range
  // rates.
  const double factor =
      std::clamp(targets.SpeedFactor(trial.expected_rad), 1.0 / kMaxSpeedFactor, kMaxSpeedFactor);
  targets.MultiplySpeed(factor);
  const int count = targets.CountInliers(trial.expected_rad, options.inlier_gate_mps);
  targets.MultiplySpeed(1.0 / factor);
  if (count > most && count > targets.BestAngle(0.0, kAnywhere_rad, options).inlier_count) {
    targets.MultiplySpeed(factor);
    best_rad = trial.expected_rad;
    most = count;
  }
  if (!is_enough(most)) return std::nullopt;
  const double first_rad = targets.Refine(best_rad, options).value;
  if (!is_enough(targets.CountInliers(first_rad, options.inlier_gate_mps))) return std::nullopt;
  if (targets.CountDirectionsOfInliers(first_rad, options.inlier_gate_mps) <
      trial.min_direction_count) {
    return std::nullopt;
  }
  ScalarEstimate reading = targets.Refine(first_rad, options);
  reading.variance += std::pow(options.reading_sigma_rad, 2) + targets.DirectionVariance(velocity);
  return reading;
}

bool MountYawEstimator::OnScan(Stamp stamp, const Scan& scan, const RadarModel& radar,
                               const EgoVelocity& velocity, MountYawWorkspace& workspace) {
  if (velocity.linear_mps.head<2>().norm() < options_.min_speed_mps ||
      std::abs(velocity.angular_radps.z()) > options_.max_yaw_rate_radps) {
    return false;
  }
  const std::chrono::nanoseconds since_last = last_ ? stamp - *last_ : options_.interval;
  if (since_last < options_.interval && !HasRecentOutliers(stamp)) return false;
  if (since_last > options_.outlier_span) outliers_rad_.clear();
  const auto reading_by = [&](const MountYawTrial& trial) {
    return MountYawOfScan(scan, radar, velocity, trial, options_, workspace);
  };
  std::optional<ScalarEstimate> reading =
      reading_by({.expected_rad = error_.value, .around_rad = kNear_rad});
  if (!reading) {
    reading = reading_by(
        {.around_rad = kAnywhere_rad, .min_direction_count = options_.min_direction_count});
  }
  if (!reading) return false;
  last_ = stamp;
  error_.variance +=
      std::pow(options_.drift_sigma_rad, 2) * std::chrono::duration<double>(since_last).count();
  KalmanUpdate(*reading);
  return true;
}

void MountYawEstimator::KalmanUpdate(const ScalarEstimate& reading) {
  const double innovation = reading.value - error_.value;
  const double spread = error_.variance + reading.variance;
  if (innovation * innovation > std::pow(options_.outlier_sigmas, 2) * spread) {
    if (!IsOfKnockedMount(reading)) return;
    error_ = reading;
    reading_count_ = 1;
  } else {
    const double gain = error_.variance / spread;
    error_ = {error_.value + gain * innovation, (1.0 - gain) * error_.variance};
    ++reading_count_;
  }
  outliers_rad_.clear();
}

bool MountYawEstimator::IsOfKnockedMount(const ScalarEstimate& reading) {
  if (!outliers_rad_.empty() &&
      std::abs(reading.value - outliers_rad_.back()) > options_.knocked_spread_rad) {
    outliers_rad_.clear();
  }
  outliers_rad_.push_back(reading.value);
  return static_cast<int>(outliers_rad_.size()) >= options_.knocked_readings;
}

}  // namespace dcloc
