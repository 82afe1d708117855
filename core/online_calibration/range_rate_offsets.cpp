#include "core/online_calibration/range_rate_offsets.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/radar/directions.h"
#include "core/radar/measurement.h"

namespace dcloc {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double Residual(const RangeRateOffsetTarget& target, const Vector3d& state) {
  return target.range_rate_mps - target.row.dot(state);
}

// An error of the azimuth turns the row.
double VarianceAt(const RangeRateOffsetTarget& target, const Vector3d& state) {
  const double across_mps = target.row.x() * state.y() - target.row.y() * state.x();
  return std::pow(target.sigma_mps, 2) + std::pow(target.azimuth_sigma_rad * across_mps, 2);
}

void TakeTargets(const Scan& scan, const RadarModel& radar, RangeRateOffsetWorkspace& targets) {
  constexpr std::size_t kMaxCount = 150;  // of more, every n-th is enough, and bounds the time
  const std::size_t stride = (scan.size() + kMaxCount - 1) / kMaxCount;
  targets.clear();
  for (std::size_t i = 0; i < scan.size(); i += stride) {
    const Measurement measurement = MeasurementAt(scan, i, radar);
    const Vector3d u = LineOfSight(measurement.azimuth_rad, measurement.elevation_rad);
    targets.push_back({.row = {-u.x(), -u.y(), 1.0},
                       .range_rate_mps = measurement.range_rate_mps,
                       .sigma_mps = measurement.range_rate_sigma_mps,
                       .azimuth_sigma_rad = measurement.azimuth_sigma_rad,
                       .direction = DirectionOf(u)});
  }
}

// The state that most targets agree on among those through three of them.
Vector3d RansacState(const RangeRateOffsetWorkspace& targets, std::uint32_t seed,
                     const RangeRateOffsetOptions& options) {
  constexpr double kMinDeterminant = 0.03;  // of rows that lie close together
  std::minstd_rand random(seed);
  std::uniform_int_distribution<std::size_t> pick(0, targets.size() - 1);
  Vector3d best = Vector3d::Zero();
  double best_votes = 0.0;
  for (int iteration = 0; iteration < options.ransac_iterations; ++iteration) {
    const RangeRateOffsetTarget& a = targets[pick(random)];
    const RangeRateOffsetTarget& b = targets[pick(random)];
    const RangeRateOffsetTarget& c = targets[pick(random)];
    Matrix3d system;
    system << a.row.transpose(), b.row.transpose(), c.row.transpose();
    if (std::abs(system.determinant()) < kMinDeterminant) continue;
    const Vector3d state =
        system.inverse() * Vector3d(a.range_rate_mps, b.range_rate_mps, c.range_rate_mps);
    double votes = 0.0;
    for (const RangeRateOffsetTarget& target : targets) {
      if (std::abs(Residual(target, state)) <= options.inlier_gate_mps) votes += target.vote;
    }
    if (votes <= best_votes) continue;
    best_votes = votes;
    best = state;
  }
  return best;
}

}  // namespace

std::span<const OptionField<RangeRateOffsetOptions>> FieldsOf(
    const RangeRateOffsetOptions& /*options*/) {
  using O = RangeRateOffsetOptions;
  static constexpr OptionField<O> kFields[] = {
      {"interval_ms", &O::interval, 0, 1e5, "each scan is read"},
      {"ransac_iterations", &O::ransac_iterations, 1, 10'000},
      {"inlier_gate_mps", &O::inlier_gate_mps, 1e-6, 100},
      {"min_inlier_count", &O::min_inlier_count, 4, 1000},
      {"min_inlier_fraction", &O::min_inlier_fraction, 0, 1, "the count alone decides"},
      {"min_direction_count", &O::min_direction_count, 0, kDirectionCount,
       "a mover may set an offset"},
      {"max_direction_fraction", &O::max_direction_fraction, 1e-3, 1},
      {"max_reading_sigma_mps", &O::max_reading_sigma_mps, 1e-6, 100},
      {"reading_sigma_mps", &O::reading_sigma_mps, 1e-6, 100},
      {"forgetting_factor", &O::forgetting_factor, 0, 0.999, "the newest reading counts alone"},
      {"height_fraction", &O::height_fraction, 0, 1, "targets lie in the plane"},
      {"height_sigma_fraction", &O::height_sigma_fraction, 1e-6, 1},
      {"min_reading_count", &O::min_reading_count, 1, 10'000},
      {"evident_sigmas", &O::evident_sigmas, 0, 1000, "each reading is evident"},
      {"min_offset_mps", &O::min_offset_mps, 1e-6, 100},
      {"min_change_mps", &O::min_change_mps, 0, 100, "each new estimate is applied"},
      {"outlier_mps", &O::outlier_mps, 1e-6, 100},
  };
  return kFields;
}

absl::Status Validate(const RangeRateOffsetOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<RangeRateOffsetReading> RangeRateOffsetOfScan(const Scan& scan,
                                                            const RadarModel& radar,
                                                            std::uint32_t seed,
                                                            const RangeRateOffsetOptions& options,
                                                            RangeRateOffsetWorkspace& targets) {
  // Which multiple an aliased range rate is off by depends on the motion that is looked for.
  if (radar.unambiguous_range_rate_mps > 0.0) return std::nullopt;
  if (scan.size() < static_cast<std::size_t>(options.min_inlier_count)) return std::nullopt;
  TakeTargets(scan, radar, targets);
  const double votes = ShareVotes(options.max_direction_fraction, targets);
  Vector3d state = RansacState(targets, seed, options);
  Matrix3d normal;
  double range_rate_sum_mps = 0.0;
  double squares = 0.0;
  int count = 0;
  for (int pass = 0; pass < 2; ++pass) {  // inliers and weights depend on the state
    normal.setZero();
    range_rate_sum_mps = 0.0;
    Vector3d right = Vector3d::Zero();
    Directions directions;
    double agreeing = 0.0;
    squares = 0.0;
    count = 0;
    for (const RangeRateOffsetTarget& target : targets) {
      const double residual = Residual(target, state);
      if (std::abs(residual) > options.inlier_gate_mps) continue;
      const double weight = 1.0 / VarianceAt(target, state);
      normal += weight * target.row * target.row.transpose();
      right += weight * target.range_rate_mps * target.row;
      squares += weight * residual * residual;
      agreeing += target.vote;
      directions.set(static_cast<std::size_t>(target.direction));
      range_rate_sum_mps += target.range_rate_mps;
      ++count;
    }
    if (count < options.min_inlier_count || agreeing < options.min_inlier_fraction * votes ||
        static_cast<int>(directions.count()) < options.min_direction_count) {
      return std::nullopt;
    }
    state = normal.ldlt().solve(right);
  }
  const double scale = std::max(1.0, squares / (count - 3.0));
  const double variance = scale * normal.inverse()(2, 2);
  if (!(variance <= options.max_reading_sigma_mps * options.max_reading_sigma_mps)) {
    return std::nullopt;
  }
  return RangeRateOffsetReading{.offset_mps = {state(2), variance},
                                .approach_mps = -range_rate_sum_mps / count};
}

bool RangeRateOffsets::OnScan(Stamp stamp, std::size_t index, const Scan& scan,
                              const RadarModel& radar) {
  Watched& watched = radars_[index];
  if (watched.last && stamp - *watched.last < options_.interval) return false;
  watched.last = stamp;  // also where it tells nothing: looking costs as much
  const auto seed = static_cast<std::uint32_t>(stamp.time_since_epoch().count());
  const auto reading = RangeRateOffsetOfScan(scan, radar, seed, options_, workspace_);
  if (!reading) return false;
  Add(*reading, watched);
  const double offset_mps = EvidentOffset(watched);
  if (std::abs(offset_mps - watched.applied_mps) < options_.min_change_mps) return false;
  watched.applied_mps = offset_mps;
  return true;
}

// One that differs much from what those before it say begins anew.
void RangeRateOffsets::Add(const RangeRateOffsetReading& reading, Watched& watched) const {
  const double offset_mps = reading.offset_mps.value;
  const Eigen::Vector2d row(1.0, reading.approach_mps);
  if (watched.reading_count > 0 &&
      std::abs(offset_mps - row.dot(watched.state)) > options_.outlier_mps) {
    watched = {.last = watched.last, .applied_mps = watched.applied_mps};
  }
  const double weight =
      1.0 / (reading.offset_mps.variance + options_.reading_sigma_mps * options_.reading_sigma_mps);
  watched.normal = options_.forgetting_factor * watched.normal + weight * row * row.transpose();
  watched.right = options_.forgetting_factor * watched.right + weight * offset_mps * row;
  ++watched.reading_count;
  Eigen::Matrix2d normal = watched.normal;
  const double information = 1.0 / std::pow(options_.height_sigma_fraction, 2);
  normal(1, 1) += information;
  const Eigen::Matrix2d covariance = normal.inverse();
  const Eigen::Vector2d known(0.0, information * options_.height_fraction);
  watched.state = covariance * (watched.right + known);
  watched.offset_sigma_mps = std::sqrt(covariance(0, 0));
}

// What was found before holds while it is about right, or too little speaks for another one.
double RangeRateOffsets::EvidentOffset(const Watched& watched) const {
  if (watched.reading_count < options_.min_reading_count) return watched.applied_mps;
  const double size_mps = std::abs(watched.state(0));
  const double least_mps =
      std::max(options_.min_offset_mps, options_.evident_sigmas * watched.offset_sigma_mps);
  if (size_mps >= least_mps) return watched.state(0);
  return size_mps >= 0.5 * least_mps ? watched.applied_mps : 0.0;
}

}  // namespace dcloc
