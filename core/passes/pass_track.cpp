#include "core/passes/pass_track.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace dcloc {
namespace {

// Odometry drifts over a stretch as if it were this long at least.
constexpr double kMinEdge_m = 1.0;
constexpr int kSmoothingSteps = 3;

/// What a quarter turn to the left makes of `v`: by which a small turn moves it.
Eigen::Vector2d Left(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// Sums of J^T W J and J^T W e over blocks of three unknowns.
class NormalEquations {
 public:
  explicit NormalEquations(std::size_t block_count)
      : gradient_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * block_count))) {}

  /// A term e + sum J x with weights W: pairs of a block and its J.
  using Jacobians = std::vector<std::pair<std::size_t, Eigen::Matrix3d>>;
  void Add(const Jacobians& jacobians, const Eigen::Matrix3d& weight,
           const Eigen::Vector3d& error) {
    for (const auto& [row, J_row] : jacobians) {
      for (const auto& [column, J_column] : jacobians) {
        AddHessian(row, column, J_row.transpose() * weight * J_column);
      }
      AddGradient(row, J_row.transpose() * weight * error);
    }
  }

  void AddHessian(std::size_t row, std::size_t column, const Eigen::Matrix3d& value) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        triplets_.emplace_back(static_cast<int>(3 * row) + r, static_cast<int>(3 * column) + c,
                               value(r, c));
      }
    }
  }
  void AddGradient(std::size_t row, const Eigen::Vector3d& value) {
    gradient_.segment<3>(static_cast<Eigen::Index>(3 * row)) += value;
  }

  /// The step to the least sum of squares.
  Eigen::VectorXd Solve() const {
    Eigen::SparseMatrix<double> hessian(gradient_.size(), gradient_.size());
    hessian.setFromTriplets(triplets_.begin(), triplets_.end());
    return -Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(hessian).solve(gradient_);
  }

 private:
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::VectorXd gradient_;
};

Eigen::Matrix3d Weights(double sigma_m, double sigma_rad) {
  return Eigen::Vector3d(1.0 / (sigma_m * sigma_m), 1.0 / (sigma_m * sigma_m),
                         1.0 / (sigma_rad * sigma_rad))
      .asDiagonal();
}

Eigen::Vector3d DeviationOf(const Pose2& T_a_b, const Pose2& T_a_c) {
  Eigen::Vector3d difference;
  difference << T_a_c.translation_m - T_a_b.translation_m, WrapAngle(T_a_c.yaw_rad - T_a_b.yaw_rad);
  return difference;
}

}  // namespace

PassTrack::PassTrack(const PlacedPass& pass, const PassTrackOptions& options) : options_(options) {
  double from_knot_m = 0.0;
  std::vector<double> at_m;  // of each scan, from its knot
  for (std::size_t i = 0; i < pass.scans.size(); ++i) {
    const PlacedScan& scan = pass.scans[i];
    if (!scan.is_good) continue;
    if (!scans_.empty()) {
      from_knot_m +=
          (scan.T_start_vehicle.translation_m - T_start_vehicles_.back().translation_m).norm();
    }
    // What is given and what is not do not share a knot.
    const bool begins =
        scans_.empty() || pass.scans[scans_.back()].is_beyond_map != scan.is_beyond_map;
    if (begins || from_knot_m >= options.knot_spacing_m) {
      if (!scans_.empty()) {
        const PlacedScan& last = pass.scans[scans_[knot_scans_.back()]];
        edges_.push_back(
            {.T_from_to = last.T_start_vehicle.Inverse() * scan.T_start_vehicle,
             .length_m = from_knot_m,
             .duration_s = std::chrono::duration<double>(scan.stamp - last.stamp).count()});
      }
      knot_scans_.push_back(scans_.size());
      given_.push_back(Flatten(scan.T_map_vehicle));
      given_weights_.push_back(scan.is_beyond_map
                                   ? Weights(options.beyond_sigma_m, options.beyond_sigma_rad)
                                   : Weights(options.pose_sigma_m, options.pose_sigma_rad));
      from_knot_m = 0.0;
    }
    knot_of_.push_back(knot_scans_.size() - 1);
    at_m.push_back(from_knot_m);
    scans_.push_back(i);
    T_start_vehicles_.push_back(scan.T_start_vehicle);
  }
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const double length_m = knot_of_[i] < edges_.size() ? edges_[knot_of_[i]].length_m : 0.0;
    fraction_.push_back(length_m > 0.0 ? at_m[i] / length_m : 0.0);
  }
  knots_ = given_;
  PlaceScans();
  const std::vector<PosePull> none(scans_.size());
  for (int step = 0; step < kSmoothingSteps; ++step) Move(none);
}

void PassTrack::Move(std::span<const PosePull> pulls) {
  const std::size_t constants = knots_.size();  // the block of scale and yaw-rate bias
  NormalEquations equations(knots_.size() + 1);
  equations.Add({{constants, Eigen::Matrix3d::Identity()}},
                Eigen::Vector3d(1.0 / std::pow(options_.scale_sigma, 2),
                                1.0 / std::pow(options_.yaw_rate_sigma_radps, 2), 1.0)
                    .asDiagonal(),
                {scale_, yaw_rate_bias_radps_, 0.0});
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const Pose2 T_given_knot = given_[k].Inverse() * knots_[k];
    Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
    J.topLeftCorner<2, 2>() = T_given_knot.Rotation();
    equations.Add({{k, J}}, given_weights_[k], DeviationOf(Pose2{}, T_given_knot));
  }
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    const Edge& edge = edges_[k];
    const double turn_rad = yaw_rate_bias_radps_ * edge.duration_s;
    const Eigen::Vector2d z_m = Eigen::Rotation2Dd(0.5 * turn_rad) * edge.T_from_to.translation_m;
    const Pose2 T_expected{(1.0 + scale_) * z_m, edge.T_from_to.yaw_rad + turn_rad};
    const Pose2 T_from_to = knots_[k].Inverse() * knots_[k + 1];
    Eigen::Matrix3d J_from = -Eigen::Matrix3d::Identity();
    J_from.topRightCorner<2, 1>() = -Left(T_from_to.translation_m);
    Eigen::Matrix3d J_to = Eigen::Matrix3d::Identity();
    J_to.topLeftCorner<2, 2>() = T_from_to.Rotation();
    Eigen::Matrix3d J_constants = Eigen::Matrix3d::Zero();
    J_constants.topLeftCorner<2, 1>() = -z_m;
    J_constants.block<2, 1>(0, 1) = -0.5 * edge.duration_s * Left(T_expected.translation_m);
    J_constants(2, 1) = -edge.duration_s;
    const double root = std::sqrt(std::max(kMinEdge_m, edge.length_m));
    equations.Add({{k, J_from}, {k + 1, J_to}, {constants, J_constants}},
                  Weights(options_.drift_m * root, options_.drift_rad * root),
                  DeviationOf(T_expected, T_from_to));
  }
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const std::size_t k = knot_of_[i];
    const double f = fraction_[i];
    const std::pair<std::size_t, double> shares[] = {{k, 1.0 - f}, {k + 1, f}};
    for (const auto& [row, share] : shares) {
      if (share == 0.0) continue;
      equations.AddGradient(row, -share * pulls[i].pull);
      for (const auto& [column, other] : shares) {
        if (other != 0.0) equations.AddHessian(row, column, share * other * pulls[i].information);
      }
    }
  }
  const Eigen::VectorXd step = equations.Solve();
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    knots_[k] = knots_[k] * Exp(Eigen::Vector3d(step.segment<3>(static_cast<Eigen::Index>(3 * k))));
  }
  scale_ += step(static_cast<Eigen::Index>(3 * constants));
  yaw_rate_bias_radps_ += step(static_cast<Eigen::Index>(3 * constants) + 1);
  PlaceScans();
}

void PassTrack::PlaceScans() {
  T_map_vehicles_.clear();
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    const std::size_t k = knot_of_[i];
    const Pose2 T_knot_scan = T_start_vehicles_[knot_scans_[k]].Inverse() * T_start_vehicles_[i];
    Pose2 T_map_vehicle = knots_[k] * T_knot_scan;
    if (k < edges_.size()) {
      // What the next knot is moved by against odometry, this scan is moved by its share.
      const Pose2 T_next_expected_next =
          (knots_[k] * edges_[k].T_from_to).Inverse() * knots_[k + 1];
      T_map_vehicle =
          T_map_vehicle * Exp(Eigen::Vector3d(fraction_[i] * Log(T_next_expected_next)));
    }
    T_map_vehicles_.push_back(T_map_vehicle);
  }
}

}  // namespace dcloc
