#include "core/calibration/gaussian_overlap.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/container/btree_map.h"

namespace dcloc {
namespace {

constexpr int kN = kCalibrationParameters;
using Jacobian = Eigen::Matrix<double, 2, kN>;

constexpr double kGate = 9.0;  // squared Mahalanobis distance beyond which a pair has no weight

// One return of a pair, with its Jacobian in units of the scale and taken at `middle_m`.
struct Side {
  Side(const StaticReturn& item, const ScanGeometry& scan, const Eigen::Vector2d& middle_m,
       const Eigen::VectorXd& parameters, const Eigen::VectorXd& scale)
      : at(static_cast<Eigen::Index>(scan.radar) * kN),
        jacobian(JacobianByParameters(scan, middle_m, item.cos_elevation) *
                 scale.segment<kN>(at).asDiagonal()),
        position_m(item.position_m + jacobian * parameters.segment<kN>(at)) {}

  Eigen::Index at;
  Jacobian jacobian;
  Eigen::Vector2d position_m;
};

using Square = std::pair<std::int64_t, std::int64_t>;

Square SquareAt(const Eigen::Vector2d& position_m, double block_m) {
  return {static_cast<std::int64_t>(std::floor(position_m.x() / block_m)),
          static_cast<std::int64_t>(std::floor(position_m.y() / block_m))};
}

}  // namespace

void AddOverlap(const FrameReturns& frame, std::span<const ReturnPair> pairs,
                const Eigen::VectorXd& parameters, const Eigen::VectorXd& scale,
                const OverlapKernel& kernel, OverlapTerms& terms) {
  absl::btree_map<Square, Eigen::VectorXd> gradients;
  const Eigen::Matrix2d scatterer_m2 =
      kernel.scatterer_sigma_m * kernel.scatterer_sigma_m * Eigen::Matrix2d::Identity();
  for (const auto& [first, second] : pairs) {
    const StaticReturn& one = frame.returns[first];
    const StaticReturn& other = frame.returns[second];
    if (std::min(one.range_m, other.range_m) < kernel.min_range_m) continue;
    const Eigen::Vector2d middle_m = 0.5 * (one.position_m + other.position_m);
    const Side a(one, frame.scans[one.scan], middle_m, parameters, scale);
    const Side b(other, frame.scans[other.scan], middle_m, parameters, scale);
    const Eigen::Matrix2d covariance_m2 = one.covariance_m2 + other.covariance_m2 + scatterer_m2;
    const Eigen::Matrix2d information = covariance_m2.inverse();
    const Eigen::Vector2d offset_m = b.position_m - a.position_m;
    const double distance = offset_m.dot(information * offset_m);
    if (distance > kGate) continue;

    const double weight = std::exp(-0.5 * distance) / std::sqrt(covariance_m2.determinant());
    const Jacobian weighted_a = weight * information * a.jacobian;
    const Jacobian weighted_b = weight * information * b.jacobian;
    const Eigen::Matrix<double, kN, kN> mixed = a.jacobian.transpose() * weighted_b;
    terms.hessian.block<kN, kN>(a.at, a.at) += a.jacobian.transpose() * weighted_a;
    terms.hessian.block<kN, kN>(b.at, b.at) += b.jacobian.transpose() * weighted_b;
    terms.hessian.block<kN, kN>(a.at, b.at) -= mixed;
    terms.hessian.block<kN, kN>(b.at, a.at) -= mixed.transpose();

    Eigen::VectorXd& gradient = gradients[SquareAt(middle_m, kernel.block_m)];
    if (gradient.size() == 0) gradient = Eigen::VectorXd::Zero(scale.size());
    gradient.segment<kN>(a.at) += weighted_a.transpose() * offset_m;
    gradient.segment<kN>(b.at) -= weighted_b.transpose() * offset_m;
  }
  for (const auto& [square, gradient] : gradients) {
    terms.gradient += gradient;
    terms.spread += gradient * gradient.transpose();
  }
}

}  // namespace dcloc
