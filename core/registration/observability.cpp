#include "core/registration/observability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

// An even choice of so many points is enough for a share of the score.
constexpr std::size_t kPoints = 300;
// In streets a shift costs a third of the score and more, between smooth walls nothing. Facades and
// rails in dense maps look like themselves a metre further, but not three (METHOD 9, decision
// 0012).
struct Shift {
  double length_m;
  double min_drop;  // of the score, as a share of it
};
constexpr Shift kShifts[] = {{1.0, 0.05}, {3.0, 0.15}};
// Far beyond what a registration can be off by, so that it says nothing along such a direction.
constexpr double kDegenerateSigma_m = 10.0;

template <int Dim>
double Score(std::size_t point_count, std::span<const Correspondence<Dim>> correspondences,
             const Pose<Dim>& T) {
  const Eigen::Matrix<double, Dim, Dim> R = T.Rotation();
  double score = 0.0;
  for (const Correspondence<Dim>& pair : correspondences) {
    const Eigen::Matrix<double, Dim, 1> e = pair.q - (R * pair.p + T.translation_m);
    score += std::exp(-0.5 * e.dot(pair.information * e));
  }
  return score / static_cast<double>(point_count);
}

}  // namespace

bool Observability::Observed(int axis) const {
  return std::ranges::none_of(directions, [&](const Direction& direction) {
    return !direction.observed && std::abs(direction.axis(axis)) > 0.5;
  });
}

std::bitset<6> Observability::ObservedDof(bool in_space) const {
  std::bitset<6> observed(in_space ? 0b111100 : 0b100000);
  for (int axis = 0; axis < 2; ++axis) observed[static_cast<std::size_t>(axis)] = Observed(axis);
  return observed;
}

Eigen::Matrix2d Observability::DegeneracyCovariance() const {
  Eigen::Matrix2d degeneracy = Eigen::Matrix2d::Zero();
  for (const Direction& direction : directions) {
    if (direction.observed) continue;
    degeneracy +=
        kDegenerateSigma_m * kDegenerateSigma_m * direction.axis * direction.axis.transpose();
  }
  return degeneracy;
}

template <int Dim>
Observability Observe(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                      const Pose<Dim>& T_local_vehicle, const TangentMatrix<Dim>& covariance,
                      const CorrespondenceGates& gates, std::vector<GaussianPoint<Dim>>& chosen,
                      CorrespondenceFinder<Dim>& finder) {
  const std::size_t stride = std::max<std::size_t>(1, live.size() / kPoints);
  chosen.clear();
  for (std::size_t i = 0; i < live.size(); i += stride) chosen.push_back(live[i]);
  finder.Begin(chosen, map, gates);
  const auto score = [&](const Pose<Dim>& T) {
    return Score<Dim>(chosen.size(), finder.Find(T, 0.0), T);
  };
  const double here = score(T_local_vehicle);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(
      covariance.template topLeftCorner<2, 2>());
  Observability observability;
  if (!(here > 0.0)) return observability;
  for (int i = 0; i < 2; ++i) {
    auto& direction = observability.directions.at(static_cast<std::size_t>(i));
    direction.axis = solver.eigenvectors().col(1 - i);
    direction.observed = std::ranges::any_of(kShifts, [&](const Shift& shift) {
      Tangent<Dim> aside = Tangent<Dim>::Zero();
      aside.template head<2>() = shift.length_m * direction.axis;
      const double there = std::max(score(T_local_vehicle * Exp(aside)),
                                    score(T_local_vehicle * Exp(Tangent<Dim>(-aside))));
      return there <= (1.0 - shift.min_drop) * here;
    });
  }
  return observability;
}

template Observability Observe<2>(std::span<const GaussianPoint<2>>, const LocalMap<2>&,
                                  const Pose2&, const TangentMatrix<2>&, const CorrespondenceGates&,
                                  std::vector<GaussianPoint<2>>&, CorrespondenceFinder<2>&);
template Observability Observe<3>(std::span<const GaussianPoint<3>>, const LocalMap<3>&,
                                  const Pose3&, const TangentMatrix<3>&, const CorrespondenceGates&,
                                  std::vector<GaussianPoint<3>>&, CorrespondenceFinder<3>&);

}  // namespace dcloc
