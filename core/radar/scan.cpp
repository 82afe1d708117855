#include "core/radar/scan.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

constexpr double kPi_rad = 3.1415927410125732;  // pi as a float rounds it: up

struct Column {
  const char* name;
  const std::vector<float>& values;
  double min;
  double max;
  bool required;
};

absl::Status CheckColumn(const Column& column, std::size_t size) {
  if (!column.required && column.values.empty()) return absl::OkStatus();
  if (column.values.size() != size) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s has %d values; range_m has %d, and columns must be of equal length",
                        column.name, column.values.size(), size));
  }
  for (std::size_t row = 0; row < size; ++row) {
    const double value = column.values[row];
    // Written so that NaN fails; infinity lies outside of every bound.
    if (value >= column.min && value <= column.max && std::isfinite(value)) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "%s[%d] is %g; it must lie in [%g, %g]", column.name, row, value, column.min, column.max));
  }
  return absl::OkStatus();
}

absl::Status CheckNorm(const char* field, const Eigen::Vector3d& vector, double max_norm) {
  if (vector.allFinite() && vector.norm() <= max_norm) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat("%s is (%g, %g, %g); its norm must be <= %g",
                                                    field, vector.x(), vector.y(), vector.z(),
                                                    max_norm));
}

absl::Status CheckTick(const MotionTick& tick, std::size_t index, const ScanLimits& limits) {
  const auto check = [&](const char* field, double value, double bound) {
    if (std::abs(value) <= bound) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrFormat("motion.%s[%d] is %g; it must be in [%g, %g]",
                                                      field, index, value, -bound, bound));
  };
  absl::Status status = check("stamp_offset_ns", static_cast<double>(tick.after_scan.count()),
                              static_cast<double>(limits.max_tick_age.count()));
  status.Update(check("speed_mps", tick.speed_mps, limits.max_speed_mps));
  status.Update(check("yaw_rate_radps", tick.yaw_rate_radps, limits.max_turn_rate_radps));
  return status;
}

absl::Status CheckTicks(const Scan& scan, const ScanLimits& limits) {
  if (scan.ticks.size() > limits.max_ticks) {
    return absl::InvalidArgumentError(absl::StrFormat("motion has %d ticks; the limit is %d",
                                                      scan.ticks.size(), limits.max_ticks));
  }
  for (std::size_t i = 0; i < scan.ticks.size(); ++i) {
    if (absl::Status status = CheckTick(scan.ticks[i], i, limits); !status.ok()) return status;
    if (i > 0 && scan.ticks[i].after_scan <= scan.ticks[i - 1].after_scan) {
      return absl::InvalidArgumentError(
          absl::StrFormat("motion.stamp_offset_ns[%d] is not later than the one before it", i));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Validate(const Scan& scan, const ScanLimits& limits) {
  if (scan.stamp < limits.min_stamp || scan.stamp > limits.max_stamp) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "stamp is %d ns; it must lie in [%d, %d] ns", scan.stamp.time_since_epoch().count(),
        limits.min_stamp.time_since_epoch().count(), limits.max_stamp.time_since_epoch().count()));
  }
  const std::size_t size = scan.size();
  if (size > limits.max_targets) {
    return absl::InvalidArgumentError(
        absl::StrFormat("range_m has %d targets; the limit is %d", size, limits.max_targets));
  }
  // A deviation of zero would be a measurement of infinite weight.
  constexpr double kMinSigma = 1e-6;
  const Column columns[] = {
      {"range_m", scan.range_m, 1e-3, limits.max_range_m, true},
      {"range_rate_mps", scan.range_rate_mps, -limits.max_range_rate_mps, limits.max_range_rate_mps,
       true},
      {"azimuth_rad", scan.azimuth_rad, -kPi_rad, kPi_rad, true},
      {"elevation_rad", scan.elevation_rad, -kPi_rad / 2, kPi_rad / 2, false},
      {"rcs_dbsm", scan.rcs_dbsm, -200.0, 200.0, false},
      {"range_sigma_m", scan.range_sigma_m, kMinSigma, limits.max_range_m, false},
      {"range_rate_sigma_mps", scan.range_rate_sigma_mps, kMinSigma, limits.max_range_rate_mps,
       false},
      {"azimuth_sigma_rad", scan.azimuth_sigma_rad, kMinSigma, kPi_rad, false},
      {"elevation_sigma_rad", scan.elevation_sigma_rad, kMinSigma, kPi_rad, false},
  };
  for (const Column& column : columns) {
    if (absl::Status status = CheckColumn(column, size); !status.ok()) return status;
  }
  const absl::Status status =
      scan.ego_velocity ? Validate(*scan.ego_velocity, limits) : absl::OkStatus();
  return status.ok() ? CheckTicks(scan, limits) : status;
}

absl::Status Validate(const EgoVelocity& ego_velocity, const ScanLimits& limits) {
  absl::Status status =
      CheckNorm("ego_velocity.linear_mps", ego_velocity.linear_mps, limits.max_speed_mps);
  status.Update(CheckNorm("ego_velocity.angular_radps", ego_velocity.angular_radps,
                          limits.max_turn_rate_radps));
  if (status.ok() && ego_velocity.covariance && !IsCovariance(*ego_velocity.covariance)) {
    return absl::InvalidArgumentError(
        "ego_velocity.covariance must be finite, symmetric and positive semidefinite");
  }
  if (status.ok() && ego_velocity.covariance &&
      ego_velocity.covariance->diagonal().maxCoeff() > limits.max_variance) {
    return absl::InvalidArgumentError(
        absl::StrFormat("ego_velocity.covariance has a variance of %g; the limit is %g",
                        ego_velocity.covariance->diagonal().maxCoeff(), limits.max_variance));
  }
  return status;
}

}  // namespace dcloc
