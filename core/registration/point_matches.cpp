#include "core/registration/point_matches.h"

#include <cmath>

namespace dcloc {
namespace {

template <int Dim>
using Vector = Eigen::Matrix<double, Dim, 1>;
template <int Dim>
using Matrix = Eigen::Matrix<double, Dim, Dim>;

// How far poses of one neighbourhood lie from its centre. Wider ones are left less often but have
// more candidates; a tracker's registration mostly stays within this.
constexpr double kNear_m = 0.1;
constexpr double kNear_rad = 0.003;

Eigen::Matrix2d Adjugate(const Eigen::Matrix2d& m) {
  Eigen::Matrix2d adjugate;
  adjugate << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
  return adjugate;
}

Eigen::Matrix3d Adjugate(const Eigen::Matrix3d& m) {
  Eigen::Matrix3d adjugate;
  adjugate.row(0) = m.col(1).cross(m.col(2)).transpose();
  adjugate.row(1) = m.col(2).cross(m.col(0)).transpose();
  adjugate.row(2) = m.col(0).cross(m.col(1)).transpose();
  return adjugate;
}

// The landmark that fits best so far: least negative log-likelihood, d^2 + log det, so that a wide
// landmark does not win by its width alone.
template <int Dim>
struct Best {
  double distance;  // squared Mahalanobis distance
  double determinant;
  const GaussianPoint<Dim>* landmark = nullptr;
  Matrix<Dim> adjugate;  // of the joint covariance

  bool IsBeatenBy(double other_distance, double other_determinant) const {
    if (landmark == nullptr) return true;
    // Most pairs are decided without the logarithm.
    if (other_distance >= distance && other_determinant >= determinant) return false;
    if (other_distance < distance && other_determinant <= determinant) return true;
    return other_distance - distance < std::log(determinant / other_determinant);
  }
};

}  // namespace

template <int Dim>
void MatchFinder<Dim>::Begin(std::span<const GaussianPoint<Dim>> live, const LocalMap<Dim>& map,
                             const MatchGates& gates) {
  live_ = live;
  map_ = &map;
  gates_ = gates;
  neighbourhood_.reset();
}

template <int Dim>
std::span<const PointMatch<Dim>> MatchFinder<Dim>::Find(const Pose<Dim>& T_local_vehicle,
                                                        double blur_m) {
  if (!Covers(T_local_vehicle, blur_m)) LookUp(T_local_vehicle, blur_m);
  const Matrix<Dim> R = T_local_vehicle.Rotation();
  const double gate = gates_.gate_sigmas * gates_.gate_sigmas;
  const double reach_m2 = gates_.reach_m * gates_.reach_m;
  matches_.clear();
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < live_.size(); ++i) {
    const std::uint32_t end = candidates_end_[i];
    if (begin == end) continue;
    const Vector<Dim> p = R * live_[i].mean_m + T_local_vehicle.translation_m;
    Matrix<Dim> covariance = R * live_[i].covariance_m2 * R.transpose();
    covariance.diagonal().array() += blur_m * blur_m;
    Best<Dim> best;
    for (; begin != end; ++begin) {
      const GaussianPoint<Dim>& landmark = map_->points()[candidates_[begin]];
      const Vector<Dim> e = landmark.mean_m - p;
      const Matrix<Dim> joint = landmark.covariance_m2 + covariance;
      const Matrix<Dim> adjugate = Adjugate(joint);
      const double determinant = joint.row(0).dot(adjugate.col(0).transpose());
      const double scaled = e.dot(adjugate * e);
      // Written so that what is not a number fails.
      if (!(determinant > 0.0 && scaled <= gate * determinant)) continue;
      if (e.squaredNorm() > reach_m2) continue;
      const double distance = scaled / determinant;
      if (best.IsBeatenBy(distance, determinant)) {
        best = {distance, determinant, &landmark, adjugate};
      }
    }
    if (best.landmark == nullptr) continue;
    matches_.push_back({live_[i].mean_m, best.landmark->mean_m, best.adjugate / best.determinant});
  }
  return matches_;
}

template <int Dim>
bool MatchFinder<Dim>::Covers(const Pose<Dim>& T_local_vehicle, double blur_m) const {
  if (!neighbourhood_ || blur_m > neighbourhood_->blur_m) return false;
  const Pose<Dim> apart = neighbourhood_->T_local_vehicle.Inverse() * T_local_vehicle;
  return apart.translation_m.norm() <= kNear_m && RotationAngle(apart) <= kNear_rad;
}

// A landmark can be within d of a point in the joint covariance's metric only if it is so along
// each axis by itself: e_x^2 <= d^2 (Q_xx + P_xx). Over the neighbourhood the point moves by up to
// `near_m`, and its own deviation along an axis turns into no more than s + angle * s_max.
template <int Dim>
void MatchFinder<Dim>::LookUp(const Pose<Dim>& T_local_vehicle, double blur_m) {
  neighbourhood_ = {T_local_vehicle, blur_m};
  const Matrix<Dim> R = T_local_vehicle.Rotation();
  const double gate = gates_.gate_sigmas * gates_.gate_sigmas;
  candidates_.clear();
  candidates_end_.clear();
  for (const GaussianPoint<Dim>& point : live_) {
    const Vector<Dim> p = R * point.mean_m + T_local_vehicle.translation_m;
    const Matrix<Dim> covariance = R * point.covariance_m2 * R.transpose();
    const double near_m = kNear_m + kNear_rad * point.mean_m.norm();
    const double turned_m = kNear_rad * std::sqrt(point.covariance_m2.trace());
    const Vector<Dim> variances =
        (covariance.diagonal().cwiseSqrt().array() + turned_m).square() + blur_m * blur_m;
    map_->ForEachNear(p.x(), p.y(), gates_.reach_m + near_m, [&](std::size_t index) {
      const GaussianPoint<Dim>& landmark = map_->points()[index];
      for (int axis = 0; axis < Dim; ++axis) {
        const double apart_m = std::abs(landmark.mean_m(axis) - p(axis)) - near_m;
        const double variance = landmark.covariance_m2(axis, axis) + variances(axis);
        // Written so that what is not a number fails.
        if (!(apart_m <= 0.0 || apart_m * apart_m <= gate * variance)) return;
      }
      candidates_.push_back(static_cast<std::uint32_t>(index));
    });
    candidates_end_.push_back(static_cast<std::uint32_t>(candidates_.size()));
  }
}

template class MatchFinder<2>;
template class MatchFinder<3>;

}  // namespace dcloc
