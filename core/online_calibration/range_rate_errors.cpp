#include "core/online_calibration/range_rate_errors.h"

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

// A scale and an offset explain much the same targets: the one found first goes on unless the other
// explains them by so much better, in gates of a target.
constexpr double kPreferredMisfit = 0.05;

}  // namespace

std::span<const OptionField<RangeRateErrorOptions>> FieldsOf(
    const RangeRateErrorOptions& /*options*/) {
  using O = RangeRateErrorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_static_fraction", &O::max_static_fraction, 0, 1, "no scale is looked for"},
      {"min_gain_fraction", &O::min_gain_fraction, 0, 1, "a scale need not be better than none"},
      {"min_range_rate_mps", &O::min_range_rate_mps, 1e-3, 100},
      {"gate_mps", &O::gate_mps, 0, 100, "the gate is in proportion to the range rate"},
      {"gate_fraction", &O::gate_fraction, 0, 1, "the gate is constant"},
      {"min_target_count", &O::min_target_count, 1, 10'000},
      {"min_direction_count", &O::min_direction_count, 0, kDirectionCount,
       "a mover may set a scale"},
      {"min_agreeing_fraction", &O::min_agreeing_fraction, 1e-3, 1},
      {"min_change", &O::min_change, 0, 100, "the smallest scale counts"},
      {"min_offset_mps", &O::min_offset_mps, 1e-6, 100},
      {"max_offset_mps", &O::max_offset_mps, 0, 100, "no offset is looked for"},
      {"max_factor", &O::max_factor, 1, 100},
      {"same_fraction", &O::same_fraction, 1e-6, 1},
      {"min_scan_count", &O::min_scan_count, 1, 10'000},
      {"min_registration_count", &O::min_registration_count, 1, 10'000},
      {"confirmed_after_ms", &O::confirmed_after, 0, 1e6, "a few registrations are enough"},
      {"kept_registration_count", &O::kept_registration_count, 0, 1'000'000, "each scale is kept"},
  };
  return kFields;
}

absl::Status Validate(const RangeRateErrorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

// METHOD section 18.
void RangeRateErrors::OnScan(Stamp stamp, std::size_t index, const Scan& scan,
                             std::size_t static_count, const RadarModel& radar,
                             const EgoVelocity& velocity) {
  Radar& watched = radars_[index];
  const auto reset = [&watched] {
    watched.supposed = {};
    watched.scan_count = 0;
    if (watched.supposed_since) watched.registration_count = 0;
    watched.supposed_since.reset();
  };
  const bool is_static = static_cast<double>(static_count) >=
                         options_.max_static_fraction * static_cast<double>(scan.size());
  const std::optional<RangeRateError> error =
      is_static ? std::nullopt : ErrorOf(scan, radar, velocity, watched);
  watched.agrees =
      !error && 2.0 * static_cast<double>(static_count) >= static_cast<double>(scan.size());
  if (watched.agrees || (disputed_ && stamp - *disputed_ > kDisputeTimeout)) {
    disputed_distance_m_ = 0.0;
    disputed_.reset();
  }
  if (watched.agrees) return reset();
  if (!error) {
    if (!watched.supposed_since) watched.scan_count = 0;
    return;
  }
  if (!IsSame(*error, watched.first)) reset();
  if (watched.scan_count == 0) watched.first = *error;
  AddDisputed(stamp, Composed({.learned = watched.learned, .supposed = *error}), velocity);
  if (++watched.scan_count < options_.min_scan_count) return;
  watched.supposed = *error;
  if (watched.supposed_since) return;
  watched.supposed_since = stamp;
  watched.registration_count = 0;
}

// A radar that others contradict disputes nothing, nor does one whose range rates are right again.
void RangeRateErrors::AddDisputed(Stamp stamp, const RangeRateError& error,
                                  const EgoVelocity& velocity) {
  if (std::ranges::any_of(radars_, &Radar::agrees)) return;
  if (disputed_ && stamp > *disputed_) {
    const double apart_mps =
        std::abs(1.0 - error.scale) * velocity.linear_mps.norm() + std::abs(error.offset_mps);
    disputed_distance_m_ += apart_mps * SecondsOf(stamp - *disputed_);
  }
  disputed_ = stamp;
}

bool RangeRateErrors::OnRegistered(Stamp stamp) {
  bool has_changed = false;
  for (Radar& radar : radars_) {
    ++radar.registration_count;
    if (!radar.supposed_since || radar.registration_count < options_.min_registration_count ||
        stamp - *radar.supposed_since < options_.confirmed_after) {
      continue;
    }
    radar = {.learned = Composed(radar)};
    has_changed = true;
    disputed_distance_m_ = 0.0;
    disputed_.reset();
  }
  return has_changed;
}

// To compensated range rates their ego-motion was added: a multiple of the sum is one more than
// that of the range rates themselves.
RangeRateError RangeRateErrors::Composed(const Radar& radar) const {
  const RangeRateError& learned = radar.learned;
  const RangeRateError& supposed = radar.supposed;
  const double scale = learned.is_compensated() && supposed.scale != 1.0
                           ? supposed.scale - 1.0
                           : learned.scale * supposed.scale;
  if (std::abs(scale) < 1.0 / options_.max_factor) return {.scale = kCompensatedScale};
  const double offset_mps = learned.offset_mps + learned.scale * supposed.offset_mps;
  return {.scale = std::abs(scale - 1.0) < options_.min_change ? 1.0 : scale,
          .offset_mps = std::abs(offset_mps) < options_.min_offset_mps ? 0.0 : offset_mps};
}

bool RangeRateErrors::IsSame(const RangeRateError& a, const RangeRateError& b) const {
  return std::abs(a.scale - b.scale) <= options_.same_fraction * std::abs(b.scale) &&
         std::abs(a.offset_mps - b.offset_mps) <= options_.gate_mps;
}

void RangeRateErrors::OnOffsetCorrected(std::size_t index) {
  Radar& radar = radars_[index];
  const int registration_count = radar.supposed_since ? 0 : radar.registration_count;
  radar = {.learned = {.scale = radar.learned.scale}, .registration_count = registration_count};
}

bool RangeRateErrors::OnLost() {
  bool has_changed = false;
  disputed_distance_m_ = 0.0;
  disputed_.reset();
  for (Radar& radar : radars_) {
    if (radar.registration_count >= options_.kept_registration_count) continue;
    has_changed = has_changed || !radar.learned.is_none();
    radar = {};
  }
  return has_changed;
}

void RangeRateErrors::TakeTargets(const Scan& scan, const RadarModel& radar,
                                  const EgoVelocity& velocity) {
  targets_.clear();
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
  }
}

double RangeRateErrors::MedianOfTargets(double (*value)(const Target&)) {
  values_.clear();
  for (const Target& target : targets_) values_.push_back(value(target));
  const auto middle = values_.begin() + static_cast<std::ptrdiff_t>(values_.size() / 2);
  std::nth_element(values_.begin(), middle, values_.end());
  return *middle;
}

std::optional<RangeRateError> RangeRateErrors::MedianScale() {
  const double ratio = MedianOfTargets(
      [](const Target& target) { return target.range_rate_mps / target.predicted_mps; });
  const double factor = std::abs(ratio);
  if (factor > options_.max_factor || std::abs(ratio - 1.0) < options_.min_change) {
    return std::nullopt;
  }
  return RangeRateError{.scale = factor < 1.0 / options_.max_factor ? kCompensatedScale : ratio};
}

std::optional<RangeRateError> RangeRateErrors::MedianOffset() {
  const double offset_mps = MedianOfTargets(
      [](const Target& target) { return target.range_rate_mps - target.predicted_mps; });
  const double size_mps = std::abs(offset_mps);
  if (size_mps < options_.min_offset_mps || size_mps > options_.max_offset_mps) {
    return std::nullopt;
  }
  return RangeRateError{.offset_mps = offset_mps};
}

double RangeRateErrors::InGates(const Target& target, const RangeRateError& error) const {
  const double expected_mps = error.scale * target.predicted_mps + error.offset_mps;
  return std::abs(target.range_rate_mps - expected_mps) /
         (options_.gate_mps + options_.gate_fraction * std::abs(expected_mps));
}

double RangeRateErrors::CountAgreeing(const RangeRateError& error) const {
  return static_cast<double>(std::ranges::count_if(
      targets_, [&](const Target& target) { return InGates(target, error) <= 1.0; }));
}

double RangeRateErrors::MisfitOf(const RangeRateError& error) const {
  double sum = 0.0;
  for (const Target& target : targets_) sum += std::min(1.0, InGates(target, error));
  return sum / static_cast<double>(targets_.size());
}

std::optional<RangeRateError> RangeRateErrors::ErrorOf(const Scan& scan, const RadarModel& radar,
                                                       const EgoVelocity& velocity,
                                                       const Radar& watched) {
  TakeTargets(scan, radar, velocity);
  if (static_cast<int>(targets_.size()) < options_.min_target_count) return std::nullopt;
  const auto count = static_cast<double>(targets_.size());
  std::optional<RangeRateError> best;
  double least_misfit = 1.0;
  for (const std::optional<RangeRateError>& error : {MedianScale(), MedianOffset()}) {
    if (!error) continue;
    const bool goes_on = watched.scan_count > 0 && error->is_offset() == watched.first.is_offset();
    const double misfit = MisfitOf(*error) - (goes_on ? kPreferredMisfit : 0.0);
    if (misfit >= least_misfit) continue;
    least_misfit = misfit;
    best = error;
  }
  if (!best) return std::nullopt;
  Directions directions;
  for (const Target& target : targets_) {
    if (InGates(target, *best) <= 1.0) directions.set(static_cast<std::size_t>(target.direction));
  }
  const double agreeing_count = CountAgreeing(*best);
  const double measured_count = CountAgreeing({});
  const double min_gain_fraction = watched.supposed_since ? 0.0 : options_.min_gain_fraction;
  if (agreeing_count < options_.min_agreeing_fraction * count ||
      agreeing_count - measured_count < min_gain_fraction * count ||
      static_cast<int>(directions.count()) < options_.min_direction_count ||
      (best->is_compensated() && measured_count > kMaxMeasuredFraction * count)) {
    return std::nullopt;
  }
  return best;
}

void CorrectRangeRates(const RangeRateError& error, Scan& scan) {
  for (float& range_rate_mps : scan.range_rate_mps) {
    range_rate_mps =
        static_cast<float>((static_cast<double>(range_rate_mps) - error.offset_mps) / error.scale);
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

void CorrectRangeRates(const RangeRateError& error, const RadarModel& radar,
                       const EgoVelocity& velocity, Scan& scan) {
  if (error.is_compensated()) {
    AddEgoMotion(radar, velocity, scan);
  } else {
    CorrectRangeRates(error, scan);
  }
}

}  // namespace dcloc
