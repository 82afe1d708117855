#include "core/online_calibration/range_rate_scales.h"

#include <algorithm>
#include <cmath>

#include "core/radar/directions.h"
#include "core/radar/measurement.h"

namespace dcloc {
namespace {

// A dispute that no scan has continued for longer than this is over: four intervals of the slowest
// radars, which scan twice a second.
constexpr std::chrono::nanoseconds kDisputeTimeout = std::chrono::seconds(2);

// Where more of the targets are as measured, those that have no range rate are a convoy.
constexpr double kMaxMeasuredFraction = 0.1;

}  // namespace

std::span<const OptionField<RangeRateScaleOptions>> FieldsOf(
    const RangeRateScaleOptions& /*options*/) {
  using O = RangeRateScaleOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_static_fraction", &O::max_static_fraction, 0, 1, "no scale is looked for"},
      {"min_range_rate_mps", &O::min_range_rate_mps, 1e-3, 100},
      {"gate_mps", &O::gate_mps, 0, 100, "the gate is in proportion to the range rate"},
      {"gate_fraction", &O::gate_fraction, 0, 1, "the gate is constant"},
      {"min_target_count", &O::min_target_count, 1, 10'000},
      {"min_direction_count", &O::min_direction_count, 0, kDirectionCount,
       "a mover may set a scale"},
      {"min_agreeing_fraction", &O::min_agreeing_fraction, 1e-3, 1},
      {"min_change", &O::min_change, 0, 100, "the smallest scale counts"},
      {"max_factor", &O::max_factor, 1, 100},
      {"same_fraction", &O::same_fraction, 1e-6, 1},
      {"min_scan_count", &O::min_scan_count, 1, 10'000},
      {"min_registration_count", &O::min_registration_count, 1, 10'000},
      {"confirmed_after_ms", &O::confirmed_after, 0, 1e6, "a few registrations are enough"},
      {"kept_registration_count", &O::kept_registration_count, 0, 1'000'000, "each scale is kept"},
  };
  return kFields;
}

absl::Status Validate(const RangeRateScaleOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

// METHOD section 18.
void RangeRateScales::OnScan(Stamp stamp, std::size_t index, const Scan& scan,
                             std::size_t static_count, const RadarModel& radar,
                             const EgoVelocity& velocity) {
  Radar& watched = radars_[index];
  const auto reset = [&watched] {
    watched.supposed = 1.0;
    watched.scan_count = 0;
    if (watched.supposed_since) watched.registration_count = 0;
    watched.supposed_since.reset();
  };
  watched.agrees = static_cast<double>(static_count) >=
                   options_.max_static_fraction * static_cast<double>(scan.size());
  if (watched.agrees || (disputed_ && stamp - *disputed_ > kDisputeTimeout)) {
    disputed_distance_m_ = 0.0;
    disputed_.reset();
  }
  if (watched.agrees) return reset();
  const std::optional<double> ratio = RatioOf(scan, radar, velocity);
  if (!ratio) {
    if (!watched.supposed_since) watched.scan_count = 0;
    return;
  }
  if (std::abs(*ratio - watched.first_ratio) >
      options_.same_fraction * std::abs(watched.first_ratio)) {
    reset();
  }
  if (watched.scan_count == 0) watched.first_ratio = *ratio;
  AddDisputed(stamp, Composed({.learned = watched.learned, .supposed = *ratio}), velocity);
  if (++watched.scan_count < options_.min_scan_count) return;
  watched.supposed = *ratio;
  if (watched.supposed_since) return;
  watched.supposed_since = stamp;
  watched.registration_count = 0;
}

// A radar that others contradict disputes nothing, nor does one whose range rates are right again.
void RangeRateScales::AddDisputed(Stamp stamp, double scale, const EgoVelocity& velocity) {
  if (std::ranges::any_of(radars_, &Radar::agrees)) return;
  if (disputed_ && stamp > *disputed_) {
    disputed_distance_m_ +=
        std::abs(1.0 - scale) * velocity.linear_mps.norm() * SecondsOf(stamp - *disputed_);
  }
  disputed_ = stamp;
}

void RangeRateScales::OnRegistered(Stamp stamp) {
  for (Radar& radar : radars_) {
    ++radar.registration_count;
    if (!radar.supposed_since || radar.registration_count < options_.min_registration_count ||
        stamp - *radar.supposed_since < options_.confirmed_after) {
      continue;
    }
    radar = {.learned = Composed(radar)};
    disputed_distance_m_ = 0.0;
    disputed_.reset();
  }
}

// To compensated range rates their ego-motion was added: a multiple of the sum is one more than
// that of the range rates themselves.
double RangeRateScales::Composed(const Radar& radar) const {
  const double scale = radar.learned == kCompensatedScale && radar.supposed != 1.0
                           ? radar.supposed - 1.0
                           : radar.learned * radar.supposed;
  if (std::abs(scale) < 1.0 / options_.max_factor) return kCompensatedScale;
  return std::abs(scale - 1.0) < options_.min_change ? 1.0 : scale;
}

void RangeRateScales::OnLost() {
  disputed_distance_m_ = 0.0;
  disputed_.reset();
  for (Radar& radar : radars_) {
    if (radar.registration_count < options_.kept_registration_count) radar = {};
  }
}

std::optional<double> RangeRateScales::RatioOf(const Scan& scan, const RadarModel& radar,
                                               const EgoVelocity& velocity) {
  targets_.clear();
  ratios_.clear();
  const Eigen::Matrix3d R_vehicle_radar = radar.T_vehicle_radar.Rotation();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Measurement measurement = MeasurementAt(scan, i, radar);
    const Eigen::Vector3d u_vehicle =
        R_vehicle_radar * LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
    const double predicted_mps = PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, velocity);
    if (std::abs(predicted_mps) < options_.min_range_rate_mps) continue;
    // A multiple of an aliased range rate cannot be unfolded.
    if (radar.unambiguous_range_rate_mps > 0.0 &&
        options_.max_factor * std::abs(predicted_mps) > radar.unambiguous_range_rate_mps) {
      continue;
    }
    targets_.push_back({.predicted_mps = predicted_mps,
                        .range_rate_mps = measurement.range_rate_mps,
                        .direction = DirectionOf(u_vehicle)});
    ratios_.push_back(measurement.range_rate_mps / predicted_mps);
  }
  if (static_cast<int>(targets_.size()) < options_.min_target_count) return std::nullopt;
  const auto middle = ratios_.begin() + static_cast<std::ptrdiff_t>(ratios_.size() / 2);
  std::nth_element(ratios_.begin(), middle, ratios_.end());
  const double factor = std::abs(*middle);
  if (factor > options_.max_factor || std::abs(*middle - 1.0) < options_.min_change) {
    return std::nullopt;
  }
  const double ratio = factor < 1.0 / options_.max_factor ? kCompensatedScale : *middle;
  const auto agrees = [this](const Target& target, double scale) {
    const double expected_mps = scale * target.predicted_mps;
    return std::abs(target.range_rate_mps - expected_mps) <=
           options_.gate_mps + options_.gate_fraction * std::abs(expected_mps);
  };
  Directions directions;
  double agreeing_count = 0.0;
  double measured_count = 0.0;
  for (const Target& target : targets_) {
    if (agrees(target, 1.0)) measured_count += 1.0;
    if (!agrees(target, ratio)) continue;
    agreeing_count += 1.0;
    directions.set(static_cast<std::size_t>(target.direction));
  }
  const auto count = static_cast<double>(targets_.size());
  if (agreeing_count < options_.min_agreeing_fraction * count ||
      static_cast<int>(directions.count()) < options_.min_direction_count ||
      (ratio == kCompensatedScale && measured_count > kMaxMeasuredFraction * count)) {
    return std::nullopt;
  }
  return ratio;
}

void DivideRangeRates(double scale, Scan& scan) {
  for (float& range_rate_mps : scan.range_rate_mps) {
    range_rate_mps = static_cast<float>(static_cast<double>(range_rate_mps) / scale);
  }
}

void AddEgoMotion(const RadarModel& radar, const EgoVelocity& velocity, Scan& scan) {
  const Eigen::Matrix3d R_vehicle_radar = radar.T_vehicle_radar.Rotation();
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Measurement measurement = MeasurementAt(scan, i, radar);
    const Eigen::Vector3d u_vehicle =
        R_vehicle_radar * LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
    scan.range_rate_mps[i] =
        static_cast<float>(measurement.range_rate_mps +
                           PredictedRangeRate(u_vehicle, radar.T_vehicle_radar, velocity));
  }
}

void CorrectRangeRates(double scale, const RadarModel& radar, const EgoVelocity& velocity,
                       Scan& scan) {
  if (scale == kCompensatedScale) {
    AddEgoMotion(radar, velocity, scan);
  } else {
    DivideRangeRates(scale, scan);
  }
}

}  // namespace dcloc
