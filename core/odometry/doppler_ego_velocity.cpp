#include "core/odometry/doppler_ego_velocity.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/geometry/covariance.h"
#include "core/radar/directions.h"
#include "core/radar/measurement.h"

namespace dcloc {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Row = RangeRateRow;

// Of more targets than any rig's single moment has, every n-th is enough, and bounds the time.
constexpr std::size_t kMaxRows = 3000;

void MakeRows(std::span<const RadarScan> scans, std::vector<Row>& rows) {  // METHOD eq 21
  rows.clear();
  std::size_t target_count = 0;
  for (const RadarScan& one : scans) target_count += one.scan->size();
  const std::size_t stride = std::max<std::size_t>(1, (target_count + kMaxRows - 1) / kMaxRows);
  for (const auto& [scan, radar, speed_gain_mps] : scans) {
    const Matrix3d R_vehicle_radar = radar->T_vehicle_radar.Rotation();
    const Vector3d& mount = radar->T_vehicle_radar.translation_m;
    for (std::size_t i = 0; i < scan->size(); i += stride) {
      const Measurement m = MeasurementAt(*scan, i, *radar);
      const Vector3d u = R_vehicle_radar * LineOfSight(m.azimuth_rad, m.elevation_rad);
      rows.push_back({.row = {-u.x(), -u.y(), -(mount.x() * u.y() - mount.y() * u.x())},
                      .range_rate_mps = m.range_rate_mps - u.x() * speed_gain_mps,
                      .unambiguous_mps = radar->unambiguous_range_rate_mps,
                      .sigma_mps = m.range_rate_sigma_mps,
                      .cross_row_sigma_rad = m.azimuth_sigma_rad,
                      .direction = DirectionOf(u)});
    }
  }
}

double VotesOf(const std::vector<Row>& rows) {
  double sum = 0.0;
  for (const Row& row : rows) sum += row.vote;
  return sum;
}

double Residual(const Row& row, const Vector3d& state) {
  const double predicted_mps = row.row.dot(state);
  return UnfoldRangeRate(row.range_rate_mps, predicted_mps, row.unambiguous_mps) - predicted_mps;
}

double Squared(double value) { return value * value; }

double VarianceAt(const Row& row, const Vector3d& state) {
  const double across_square_m2ps2 =
      std::max(0.0, state.head<2>().squaredNorm() - Squared(row.row.dot(state)));
  return Squared(row.sigma_mps) + Squared(row.cross_row_sigma_rad) * across_square_m2ps2;
}

void TakeInliers(const std::vector<Row>& rows, const Vector3d& state, double gate_mps,
                 std::vector<Row>& inliers) {
  inliers.clear();
  for (const Row& row : rows) {
    if (std::abs(Residual(row, state)) <= gate_mps) inliers.push_back(row);
  }
}

// After how many pairs one of two right targets is missed once in ten thousand times.
double PairsNeeded(double right_fraction) {
  const double wrong_pair_fraction = std::max(1e-9, 1.0 - right_fraction * right_fraction);
  return std::log(1e-4) / std::log(wrong_pair_fraction);
}

// The best-supported motion among those through two targets without side slip.
Vector3d RansacMotion(const std::vector<Row>& rows, double votes, std::uint64_t seed,
                      const EgoVelocityOptions& options) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::size_t> pick(0, rows.size() - 1);
  Vector3d best = Vector3d::Zero();
  double best_votes = 0.0;
  double pairs_needed = std::numeric_limits<double>::infinity();
  int pair_count = 0;
  for (int iteration = 0; iteration < options.ransac_iterations && pair_count < pairs_needed;
       ++iteration) {
    const Row& a = rows[pick(random)];
    const Row& b = rows[pick(random)];
    Matrix3d system;
    system << a.row.transpose(), b.row.transpose(), Vector3d::UnitY().transpose();
    // Two targets in one direction do not determine a motion.
    if (std::abs(system.determinant()) < 1e-2) continue;
    ++pair_count;
    const Vector3d state =
        system.partialPivLu().solve(Vector3d(a.range_rate_mps, b.range_rate_mps, 0.0));
    double agreeing = 0.0;
    for (const Row& row : rows) {
      if (std::abs(Residual(row, state)) <= options.inlier_gate_mps) agreeing += row.vote;
    }
    if (agreeing > best_votes) {
      best_votes = agreeing;
      best = state;
      pairs_needed = PairsNeeded(agreeing / votes);
    }
  }
  return best;
}

struct LeastSquares {
  Vector3d state;
  Matrix3d normal;           // H^T W H with the side-slip row
  double residual_variance;  // of the whitened residuals, 1 when the noise is as modelled
};

LeastSquares SolveMotion(const std::vector<Row>& rows, const Vector3d& linearization,
                         const EgoVelocityOptions& options) {  // METHOD eq 22
  LeastSquares solution;
  solution.normal = Matrix3d::Zero();
  solution.normal(1, 1) = 1.0 / (options.side_slip_sigma_mps * options.side_slip_sigma_mps);
  Vector3d right = Vector3d::Zero();
  for (const Row& row : rows) {
    const double weight = 1.0 / VarianceAt(row, linearization);
    const double range_rate_mps = row.row.dot(linearization) + Residual(row, linearization);
    solution.normal += weight * row.row * row.row.transpose();
    right += weight * range_rate_mps * row.row;
  }
  solution.state = solution.normal.ldlt().solve(right);
  double sum = 0.0;
  for (const Row& row : rows) {
    sum += Squared(Residual(row, solution.state)) / VarianceAt(row, solution.state);
  }
  solution.residual_variance = sum / std::max<double>(1.0, static_cast<double>(rows.size()) - 3.0);
  return solution;
}

bool IsWellConditioned(const Matrix3d& normal, double max_condition) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(normal, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()(0) * max_condition > solver.eigenvalues()(2);
}

void CountStandingDirections(const std::vector<Row>& rows, const Vector3d& state, double gate_mps,
                             DopplerEgoVelocity& doppler) {
  Directions moving;
  Directions standing;
  for (const Row& row : rows) {
    const bool fits_motion = std::abs(Residual(row, state)) <= gate_mps;
    const bool fits_standing = std::abs(row.range_rate_mps) <= gate_mps;
    if (fits_motion == fits_standing) continue;
    (fits_motion ? moving : standing).set(static_cast<std::size_t>(row.direction));
  }
  doppler.moving_direction_count = static_cast<int>(moving.count());
  doppler.standing_direction_count = static_cast<int>(standing.count());
}

Matrix6d PlanarTwistCovariance(const Matrix3d& planar) {
  // What the planar model fixes at zero is known to be small, not known exactly.
  constexpr double kVerticalVariance = 1e-4;
  return EmbedCovariance(planar, kVerticalVariance, kVerticalVariance);
}

EgoVelocity PlanarEgoVelocity(const Vector3d& state, const Matrix3d& covariance) {
  return {.linear_mps = {state.x(), state.y(), 0.0},
          .angular_radps = {0.0, 0.0, state.z()},
          .covariance = PlanarTwistCovariance(covariance)};
}

Matrix3d FloorVariances(double linear_sigma_mps, const EgoVelocityOptions& options) {
  return Vector3d(std::pow(linear_sigma_mps, 2), std::pow(linear_sigma_mps, 2),
                  std::pow(options.yaw_rate_sigma_floor_radps, 2))
      .asDiagonal();
}

double LinearSigmaFloor_mps(double speed_mps, const EgoVelocityOptions& options) {
  return std::min(
      options.linear_sigma_floor_mps,
      options.crawling_sigma_floor_mps + options.linear_sigma_floor_fraction * std::abs(speed_mps));
}

// The motion that most of `rows` agree on, by at least `min_fraction` of their `votes`.
std::optional<DopplerEgoVelocity> MovingEgoVelocity(const std::vector<Row>& rows, double votes,
                                                    double min_fraction, std::uint64_t seed,
                                                    const EgoVelocityOptions& options,
                                                    std::vector<Row>& inliers) {
  Vector3d state = RansacMotion(rows, votes, seed, options);
  LeastSquares solution{};
  for (int pass = 0; pass < 3; ++pass) {  // inliers and weights depend on the state: refine both
    TakeInliers(rows, state, options.inlier_gate_mps, inliers);
    if (static_cast<int>(inliers.size()) < options.min_inlier_count ||
        VotesOf(inliers) < min_fraction * votes) {
      return std::nullopt;
    }
    solution = SolveMotion(inliers, state, options);
    state = solution.state;
  }
  if (!IsWellConditioned(solution.normal, options.max_condition)) return std::nullopt;
  const Matrix3d covariance =
      std::max(1.0, solution.residual_variance) * solution.normal.inverse() +
      FloorVariances(LinearSigmaFloor_mps(state.x(), options), options);
  DopplerEgoVelocity doppler{.ego_velocity = PlanarEgoVelocity(state, covariance),
                             .inlier_count = static_cast<int>(inliers.size()),
                             .target_count = static_cast<int>(rows.size()),
                             .direction_count = CountDirections(inliers)};
  CountStandingDirections(rows, state, options.inlier_gate_mps, doppler);
  return doppler;
}

}  // namespace

std::span<const OptionField<EgoVelocityOptions>> FieldsOf(const EgoVelocityOptions& /*options*/) {
  using O = EgoVelocityOptions;
  static constexpr OptionField<O> kFields[] = {
      {"ransac_iterations", &O::ransac_iterations, 1, 10'000},
      {"inlier_gate_mps", &O::inlier_gate_mps, 1e-6, 100},
      {"min_inlier_count", &O::min_inlier_count, 3, 1000},
      {"min_inlier_fraction", &O::min_inlier_fraction, 0, 1, "the count alone decides"},
      {"side_slip_sigma_mps", &O::side_slip_sigma_mps, 1e-6, 100},
      {"zero_fraction", &O::zero_fraction, 0, 1, "a single target is enough to stand still"},
      {"zero_gate_mps", &O::zero_gate_mps, 0, 10, "only exact zeros stand still"},
      {"max_condition", &O::max_condition, 1, 1e12},
      {"max_direction_fraction", &O::max_direction_fraction, 1e-3, 1},
      {"crawling_sigma_floor_mps", &O::crawling_sigma_floor_mps, 0, 100,
       "a vehicle that hardly moves is as certain as its targets say"},
      {"linear_sigma_floor_fraction", &O::linear_sigma_floor_fraction, 0, 1,
       "the floor is the same at each speed"},
      {"linear_sigma_floor_mps", &O::linear_sigma_floor_mps, 0, 100,
       "the estimate is as certain as its targets say"},
      {"yaw_rate_sigma_floor_radps", &O::yaw_rate_sigma_floor_radps, 0, 10,
       "the estimate is as certain as its targets say"},
      {"min_alternative_fraction", &O::min_alternative_fraction, 0.01, 1},
      {"min_alternative_direction_count", &O::min_alternative_direction_count, 0, 36,
       "one mover can be an alternative of the ground"},
  };
  return kFields;
}

absl::Status Validate(const EgoVelocityOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<DopplerEgoVelocity> EstimateEgoVelocity(std::span<const RadarScan> scans,
                                                      std::uint64_t seed,
                                                      const EgoVelocityOptions& options) {
  EgoVelocityWorkspace workspace;
  return EstimateEgoVelocity(scans, seed, options, workspace);
}

std::optional<DopplerEgoVelocity> EstimateEgoVelocity(std::span<const RadarScan> scans,
                                                      std::uint64_t seed,
                                                      const EgoVelocityOptions& options,
                                                      EgoVelocityWorkspace& workspace) {
  auto& [rows, inliers] = workspace;
  MakeRows(scans, rows);
  const auto count = static_cast<int>(rows.size());
  if (count < options.min_inlier_count) return std::nullopt;
  const double votes = ShareVotes(options.max_direction_fraction, rows);

  TakeInliers(rows, Vector3d::Zero(), options.zero_gate_mps, inliers);
  if (VotesOf(inliers) >= options.zero_fraction * votes) {
    return DopplerEgoVelocity{
        .ego_velocity = PlanarEgoVelocity(Vector3d::Zero(),
                                          FloorVariances(options.linear_sigma_floor_mps, options)),
        .inlier_count = static_cast<int>(inliers.size()),
        .target_count = count,
        .direction_count = CountDirections(inliers)};
  }

  return MovingEgoVelocity(rows, votes, options.min_inlier_fraction, seed, options, inliers);
}

std::optional<DopplerEgoVelocity> EstimateAlternativeEgoVelocity(const DopplerEgoVelocity& first,
                                                                 std::uint64_t seed,
                                                                 const EgoVelocityOptions& options,
                                                                 EgoVelocityWorkspace& workspace) {
  auto& [rows, inliers] = workspace;
  const double votes = VotesOf(rows);
  const EgoVelocity& velocity = first.ego_velocity;
  const Vector3d state(velocity.linear_mps.x(), velocity.linear_mps.y(),
                       velocity.angular_radps.z());
  std::erase_if(rows, [&](const Row& row) {
    return std::abs(Residual(row, state)) <= options.inlier_gate_mps;
  });
  const double left = VotesOf(rows);
  if (static_cast<int>(rows.size()) < options.min_inlier_count ||
      left < options.min_alternative_fraction * votes) {
    return std::nullopt;
  }
  std::optional<DopplerEgoVelocity> alternative = MovingEgoVelocity(
      rows, left, options.min_alternative_fraction * votes / left, seed, options, inliers);
  if (alternative && alternative->direction_count < options.min_alternative_direction_count)
    return std::nullopt;
  return alternative;
}

EgoVelocity Fuse(const EgoVelocity& a, const EgoVelocity& b) {
  Vector6d twist_a;
  Vector6d twist_b;
  twist_a << a.linear_mps, a.angular_radps;
  twist_b << b.linear_mps, b.angular_radps;
  // gain = A (A + B)^-1; symmetric positive definite sums only, nothing is inverted alone.
  const Matrix6d sum = *a.covariance + *b.covariance;
  const Matrix6d gain = sum.ldlt().solve(*a.covariance).transpose();
  const Vector6d twist = twist_a + gain * (twist_b - twist_a);
  const Matrix6d covariance = *a.covariance - gain * *a.covariance;
  return {.linear_mps = twist.head<3>(),
          .angular_radps = twist.tail<3>(),
          .covariance = 0.5 * (covariance + covariance.transpose())};
}

}  // namespace dcloc
