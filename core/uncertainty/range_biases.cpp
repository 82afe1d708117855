#include "core/uncertainty/range_biases.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/registration/point_jacobians.h"

namespace dcloc {
namespace {

// Information [1/m^2, 1/rad^2] of motions that no point measures: a solver needs some.
constexpr double kNoInformation = 1e-6;

}  // namespace

std::span<const OptionField<RangeBiasOptions>> FieldsOf(const RangeBiasOptions& /*options*/) {
  using O = RangeBiasOptions;
  static constexpr OptionField<O> kFields[] = {
      {"scan_interval", &O::scan_interval, 1, 1'000'000},
      {"min_point_count", &O::min_point_count, 1, 1'000'000},
      {"max_point_count", &O::max_point_count, 1, 1'000'000},
      {"step_m", &O::step_m, 0.01, 10},
      {"max_correction_m", &O::max_correction_m, 0, 5, "no range is corrected"},
      {"reading_m", &O::reading_m, 0, 1000, "each scan is a reading"},
      {"suspicion_forgetting_factor", &O::suspicion_forgetting_factor, 0, 0.999,
       "the newest counts alone"},
      {"short_forgetting_factor", &O::short_forgetting_factor, 0, 0.999, "the newest counts alone"},
      {"long_forgetting_factor", &O::long_forgetting_factor, 0, 0.999, "the newest counts alone"},
      {"min_reading_count", &O::min_reading_count, 1, 10'000},
      {"reuse", &O::reuse, 1e-6, 1e6},
      {"point_variance", &O::point_variance, 1e-6, 1},
      {"min_decrease", &O::min_decrease, 1e-6, 1},
      {"landmark_sigma_m", &O::landmark_sigma_m, 1e-3, 100},
      {"min_correction_m", &O::min_correction_m, 0, 100, "each bias is corrected"},
      {"min_next_correction_m", &O::min_next_correction_m, 0, 100, "each bias is corrected"},
      {"correction_sigmas", &O::correction_sigmas, 0, 1000, "what is not certain is corrected"},
      {"next_correction_sigmas", &O::next_correction_sigmas, 0, 1000,
       "what is not certain is corrected"},
      {"suspicion_sigmas", &O::suspicion_sigmas, 0, 1000, "each bias whose size is not told"},
      {"corrected_sigma_m", &O::corrected_sigma_m, 1e-6, 10},
      {"established_reading_count", &O::established_reading_count, 1, 1'000'000},
      {"guess_m", &O::guess_m, 0, 5, "described ranges are tried again"},
      {"guess_sigma_m", &O::guess_sigma_m, 1e-6, 10},
      {"max_bias_m", &O::max_bias_m, 0, 5, "no range is corrected"},
  };
  return kFields;
}

absl::Status Validate(const RangeBiasOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void RangeBiases::OnMotion(double distance_m) {
  for (Radar& radar : radars_) radar.distance_m += distance_m;
}

bool RangeBiases::IsDue(std::size_t index, std::size_t point_count) {
  if (point_count < static_cast<std::size_t>(options_.min_point_count)) return false;
  int& count = radars_[index].scan_count;
  count = (count + 1) % options_.scan_interval;
  return count == 0;
}

std::optional<double> RangeBiases::OnFits(std::size_t index, const RangeFits& fits,
                                          double absorbed_m) {
  was_compared_ = true;
  Radar& radar = radars_[index];
  const auto count = static_cast<double>(fits.point_count);
  radar.points += count;
  radar.lean += count * (fits.shorter - fits.longer);
  radar.decrease += count * (2.0 * fits.as_measured - fits.shorter - fits.longer);
  if (radar.distance_m < options_.reading_m) return std::nullopt;
  EndReading(radar);
  if (radar.newest.count < options_.min_reading_count) return std::nullopt;

  radar.suspected_m = absorbed_m * SuspectedBias_m(radar.newest);
  const ScalarEstimate recent_m = Remaining(radar.recent);
  const ScalarEstimate many_m = Remaining(radar.many);
  const bool began_lately = IsSure(radar, recent_m);
  if (!began_lately && !IsSure(radar, many_m)) return std::nullopt;
  const ScalarEstimate& remaining_m = began_lately ? recent_m : many_m;
  const double before_m = radar.bias_m ? radar.bias_m->value : 0.0;
  const double correction_m =
      std::clamp(remaining_m.value, -options_.max_correction_m, options_.max_correction_m);
  radar.bias_m = Bounded({before_m + correction_m, remaining_m.variance});
  radar.other_m.reset();
  radar.newest = radar.recent = radar.many = {};
  radar.readings_since_correction = 0;
  return radar.bias_m->value - before_m;
}

// METHOD eq 71.
void RangeBiases::EndReading(Radar& radar) const {
  Add(radar, options_.suspicion_forgetting_factor, radar.newest);
  Add(radar, options_.short_forgetting_factor, radar.recent);
  Add(radar, options_.long_forgetting_factor, radar.many);
  radar.points = radar.lean = radar.decrease = radar.distance_m = 0.0;
  ++radar.readings_since_correction;
}

void RangeBiases::Add(const Radar& radar, double forgetting_factor, Readings& readings) const {
  readings.points = forgetting_factor * readings.points + radar.points;
  readings.lean = forgetting_factor * readings.lean + radar.lean;
  readings.decrease = forgetting_factor * readings.decrease + radar.decrease;
  const double squared = forgetting_factor * forgetting_factor;
  readings.noise = squared * readings.noise + options_.point_variance * radar.points;
  readings.lean_lean = squared * readings.lean_lean + radar.lean * radar.lean;
  readings.lean_points = squared * readings.lean_points + radar.lean * radar.points;
  readings.points_points = squared * readings.points_points + radar.points * radar.points;
  ++readings.count;
}

// Where others fit better, and neither ranges as measured nor those near them fit best, the bias is
// far off.
double RangeBiases::SuspectedBias_m(const Readings& readings) const {
  const ScalarEstimate remaining_m = Remaining(readings);
  const double bias_m = std::abs(remaining_m.value);
  const bool is_told = readings.decrease >= options_.min_decrease * readings.points;
  const bool is_chance = bias_m < options_.suspicion_sigmas * std::sqrt(remaining_m.variance);
  return is_told || is_chance ? bias_m : options_.max_bias_m;
}

ScalarEstimate RangeBiases::Remaining(const Readings& readings) const {
  const double decrease = std::max(readings.decrease, options_.min_decrease * readings.points);
  const double mean = readings.lean / readings.points;
  const double scatter =
      readings.lean_lean - 2.0 * mean * readings.lean_points + mean * mean * readings.points_points;
  const double per_lean_m = 0.5 * options_.step_m / decrease;
  return {.value = per_lean_m * readings.lean,
          .variance = options_.reuse * per_lean_m * per_lean_m * (scatter + readings.noise)};
}

bool RangeBiases::IsSure(const Radar& radar, const ScalarEstimate& remaining_m) const {
  const bool is_off = radar.bias_m.has_value();
  const double needed_m = is_off ? options_.min_next_correction_m : options_.min_correction_m;
  const double needed_sigmas =
      is_off ? options_.next_correction_sigmas : options_.correction_sigmas;
  return std::abs(remaining_m.value) >=
         std::max(needed_m, needed_sigmas * std::sqrt(remaining_m.variance));
}

double RangeBiases::suspected_m() const {
  double sum_m = 0.0;
  for (const Radar& radar : radars_) sum_m += radar.suspected_m;
  return sum_m / static_cast<double>(radars_.size());
}

void RangeBiases::Restore(std::size_t index, const ScalarEstimate& bias_m) {
  radars_[index].bias_m = Bounded(bias_m);
}

ScalarEstimate RangeBiases::Bounded(const ScalarEstimate& bias_m) const {
  return {.value = std::clamp(bias_m.value, -options_.max_bias_m, options_.max_bias_m),
          .variance = std::max(bias_m.variance, std::pow(options_.corrected_sigma_m, 2))};
}

void RangeBiases::Reset() {
  for (Radar& radar : radars_) {
    radar = {.bias_m = radar.bias_m,
             .other_m = radar.other_m,
             .suspected_m = radar.suspected_m,
             .readings_since_correction = radar.readings_since_correction};
  }
}

bool RangeBiases::TryOther() {
  Reset();
  bool is_known = false;
  for (Radar& radar : radars_) {
    const bool is_established =
        radar.bias_m && radar.readings_since_correction >= options_.established_reading_count;
    if (is_established) continue;
    is_known = is_known || radar.bias_m || radar.other_m;
    std::swap(radar.bias_m, radar.other_m);
  }
  return is_known;
}

bool RangeBiases::KnowsNothing() const {
  const bool is_guess = guess_count_ > 0;
  return !was_compared_ && (is_guess || std::ranges::none_of(radars_, [](const Radar& radar) {
                              return radar.bias_m || radar.other_m;
                            }));
}

void RangeBiases::Guess() {
  Reset();
  constexpr std::array kSigns{1.0, -1.0, 0.0};
  const double sign = kSigns.at(static_cast<std::size_t>(guess_count_++) % kSigns.size());
  for (Radar& radar : radars_) {
    radar.bias_m.reset();
    if (sign == 0.0) continue;
    radar.bias_m = {.value = sign * options_.guess_m,
                    .variance = options_.guess_sigma_m * options_.guess_sigma_m};
  }
}

template <int Dim>
double ShiftsByRange(std::span<const GaussianPoint<Dim>> points, const Eigen::Vector2d& radar_m,
                     double landmark_sigma_m, std::vector<Eigen::Vector2d>& shifts_m) {
  const Eigen::Matrix2d of_landmark =
      landmark_sigma_m * landmark_sigma_m * Eigen::Matrix2d::Identity();
  Eigen::Matrix3d information = kNoInformation * Eigen::Matrix3d::Identity();
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  shifts_m.clear();
  for (const GaussianPoint<Dim>& point : points) {
    const Eigen::Vector2d p_m = point.mean_m.template head<2>();
    const Eigen::Vector2d away = (p_m - radar_m).normalized();
    const Eigen::Matrix2d weight =
        (point.covariance_m2.template topLeftCorner<2, 2>() + of_landmark).inverse();
    const Eigen::Matrix<double, 2, 3> J = ByPose(p_m);
    information += J.transpose() * weight * J;
    pull += J.transpose() * (weight * away);
    shifts_m.push_back(away);
  }
  const Eigen::Vector3d absorbed = information.ldlt().solve(pull);
  for (std::size_t i = 0; i < points.size(); ++i) {
    shifts_m[i] -= ByPose(Eigen::Vector2d(points[i].mean_m.template head<2>())) * absorbed;
  }
  return absorbed.head<2>().norm();
}

template double ShiftsByRange<2>(std::span<const GaussianPoint<2>>, const Eigen::Vector2d&, double,
                                 std::vector<Eigen::Vector2d>&);
template double ShiftsByRange<3>(std::span<const GaussianPoint<3>>, const Eigen::Vector2d&, double,
                                 std::vector<Eigen::Vector2d>&);

}  // namespace dcloc
