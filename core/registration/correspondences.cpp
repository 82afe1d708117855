#include "core/registration/correspondences.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/registration/adjugate.h"
#include "core/registration/joint_lanes.h"

namespace dcloc {
namespace {

template <int Dim>
using Vector = Eigen::Matrix<double, Dim, 1>;
template <int Dim>
using VectorF = Eigen::Matrix<float, Dim, 1>;
template <int Dim>
using Matrix = Eigen::Matrix<double, Dim, Dim>;

// How far poses of a neighbourhood lie from its centre. Larger ones are left less often but have
// more candidates: a tracker's registration mostly stays within the wide one, and within the narrow
// one after its first step.
constexpr double kWide_m = 0.1;
constexpr double kWide_rad = 0.005;
constexpr double kNarrow_m = 0.05;
constexpr double kNarrow_rad = 0.001;
// What single precision may put a point or a landmark aside.
constexpr double kRounding_m = 1e-3;

double Squared(double value) { return value * value; }

// What the rounding of a covariance may change of a cost.
constexpr float kCostRounding = 0.02F;

}  // namespace

template <int Dim>
bool CorrespondenceFinder<Dim>::Neighbourhood::Holds(const Pose<Dim>& T, double radius_m,
                                                     double radius_rad) const {
  const Pose<Dim> apart = T_local_vehicle.Inverse() * T;
  return apart.translation_m.norm() <= radius_m && RotationAngle(apart) <= radius_rad;
}

template <int Dim>
void CorrespondenceFinder<Dim>::Begin(std::span<const GaussianPoint<Dim>> live,
                                      const LocalMap<Dim>& map, const CorrespondenceGates& gates) {
  live_ = live;
  map_ = &map;
  gates_ = gates;
  wide_.reset();
  narrow_.reset();
}

template <int Dim>
std::span<const Correspondence<Dim>> CorrespondenceFinder<Dim>::Find(
    const Pose<Dim>& T_local_vehicle, double blur_m) {
  if (!wide_ || blur_m > wide_->blur_m || !wide_->Holds(T_local_vehicle, kWide_m, kWide_rad)) {
    LookUp(T_local_vehicle, blur_m);
    narrow_.reset();
  }
  if (!narrow_ || blur_m != narrow_->blur_m ||
      !narrow_->Holds(T_local_vehicle, kNarrow_m, kNarrow_rad)) {
    Weigh(T_local_vehicle, blur_m);
  }
  const Matrix<Dim> R = T_local_vehicle.Rotation();
  const double gate = Squared(gates_.gate_sigmas);
  const double max_distance_m2 = Squared(gates_.max_distance_m);
  matches_.clear();
  matches_.reserve(live_.size());
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < live_.size(); ++i) {
    const Vector<Dim> p = R * live_[i].mean_m + T_local_vehicle.translation_m;
    const Candidate* best = nullptr;
    double best_cost = std::numeric_limits<double>::infinity();
    for (const std::uint32_t end = candidates_end_[i]; begin != end; ++begin) {
      const Candidate& candidate = candidates_[begin];
      const Vector<Dim> e = candidate.q - p;
      const double distance = e.dot(candidate.information * e);
      const double cost = distance + candidate.log_determinant;
      if (distance > gate || e.squaredNorm() > max_distance_m2 || !(cost < best_cost)) continue;
      best_cost = cost;
      best = &candidate;
    }
    if (best != nullptr) matches_.push_back({live_[i].mean_m, best->q, best->information});
  }
  return matches_;
}

// A landmark can be within d of a point in the joint covariance's metric only if it is so along
// each axis by itself: e_x^2 <= d^2 (Q_xx + P_xx). Over the neighbourhood the point moves by up to
// `near_m`, and its own deviation along an axis turns into no more than s + angle * s_max.
template <int Dim>
void CorrespondenceFinder<Dim>::LookUp(const Pose<Dim>& T_local_vehicle, double blur_m) {
  wide_ = {T_local_vehicle, blur_m};
  const Matrix<Dim> R = T_local_vehicle.Rotation();
  const auto gate = static_cast<float>(Squared(gates_.gate_sigmas));
  landmarks_end_.clear();
  std::size_t count = 0;
  for (const GaussianPoint<Dim>& point : live_) {
    const VectorF<Dim> p =
        (R * point.mean_m + T_local_vehicle.translation_m).template cast<float>();
    const Matrix<Dim> covariance = R * point.covariance_m2 * R.transpose();
    const VectorF<Dim> slant_per_m = (R * point.slant_per_m).template cast<float>();
    const double near_m = kWide_m + kWide_rad * point.mean_m.norm() + kRounding_m;
    const double turned_m = kWide_rad * std::sqrt(point.covariance_m2.trace());
    const VectorF<Dim> variances_m2 =
        ((covariance.diagonal().cwiseSqrt().array() + turned_m).square() + blur_m * blur_m)
            .template cast<float>();
    const auto moved_m = static_cast<float>(near_m);
    map_->ForEachRunNear(
        p.x(), p.y(), gates_.max_distance_m + near_m, [&](std::size_t begin, std::size_t end) {
          const std::size_t room = count + end - begin + kLaneCount;
          if (landmarks_.size() < room) landmarks_.resize(2 * room);
          for (std::size_t index = begin; index < end; index += kLaneCount) {
            const PackedLanes<Dim> landmarks = map_->LanesFrom(index);
            const std::array<Lanes, Dim> e_m = landmarks.SeenFrom(p, slant_per_m);
            LaneMask are_near = FirstLanes(end - index);
            for (int axis = 0; axis < Dim; ++axis) {
              const Lanes limits_m2 = gate * (landmarks.Variances_m2(axis) + variances_m2(axis));
              // Negative, square included, where it may come to lie at the point itself.
              const Lanes apart_m = Abs(e_m.at(static_cast<std::size_t>(axis))) - moved_m;
              are_near &= apart_m * Abs(apart_m) <= limits_m2;
            }
            // Kept or written over by the next: branches would be guessed wrong too often.
            const std::size_t lane_count = std::min(kLaneCount, end - index);
            for (std::size_t lane = 0; lane < lane_count; ++lane) {
              landmarks_[count] = map_->points()[index + lane];
              count += are_near[lane] != 0 ? 1 : 0;
            }
          }
        });
    landmarks_end_.push_back(static_cast<std::uint32_t>(count));
  }
}

template <int Dim>
void CorrespondenceFinder<Dim>::Weigh(const Pose<Dim>& T_local_vehicle, double blur_m) {
  narrow_ = {T_local_vehicle, blur_m};
  const Matrix<Dim> R = T_local_vehicle.Rotation();
  candidates_.clear();
  candidates_.reserve(live_.size());
  candidates_end_.clear();
  std::uint32_t begin = 0;
  for (std::size_t i = 0; i < live_.size(); ++i) {
    const std::uint32_t end = landmarks_end_[i];
    if (begin != end) {
      GaussianPoint<Dim> point{.mean_m = R * live_[i].mean_m + T_local_vehicle.translation_m,
                               .covariance_m2 = R * live_[i].covariance_m2 * R.transpose(),
                               .slant_per_m = R * live_[i].slant_per_m};
      point.covariance_m2.diagonal().array() += blur_m * blur_m;
      const std::span<const PackedPoint<Dim>> landmarks =
          std::span(landmarks_).subspan(begin, end - begin);
      Keep(point, landmarks,
           WeighFor(point, landmarks, kNarrow_m + kNarrow_rad * live_[i].mean_m.norm()));
    }
    begin = end;
    candidates_end_.push_back(static_cast<std::uint32_t>(candidates_.size()));
  }
}

// Over the neighbourhood a point moves by up to `near_m`, which changes its Mahalanobis distance by
// no more than near_m over the least deviation. So the cost of each landmark lies between bounds:
// `min_costs_`, infinite where it cannot pass the gates, and another, of which the least is
// returned. Who costs more than that at least cannot be the most likely.
template <int Dim>
float CorrespondenceFinder<Dim>::WeighFor(const GaussianPoint<Dim>& point,
                                          std::span<const PackedPoint<Dim>> landmarks,
                                          double near_m) {
  const Lanes never = InEachLane(std::numeric_limits<float>::infinity());
  const auto gate_sigmas = static_cast<float>(gates_.gate_sigmas);
  const auto moved_m = static_cast<float>(near_m + kRounding_m);
  const auto max_distance_m = static_cast<float>(gates_.max_distance_m);
  const float outer_m = max_distance_m + moved_m;
  const float inner_m = std::max(0.0F, max_distance_m - moved_m);
  const VectorF<Dim> p = point.mean_m.template cast<float>();
  const VectorF<Dim> slant_per_m = point.slant_per_m.template cast<float>();
  const Eigen::Matrix<float, Dim, Dim> covariance_m2 = point.covariance_m2.template cast<float>();
  min_costs_.clear();
  Lanes max_costs = never;
  for (std::size_t i = 0; i < landmarks.size(); i += kLaneCount) {
    const PackedLanes<Dim> four(&landmarks[i]);  // there is room after the last one
    const std::array<Lanes, Dim> e_m = four.SeenFrom(p, slant_per_m);
    const JointLanes<Dim> joint(four, covariance_m2);
    const Lanes determinants = joint.Determinant();
    const Lanes log_determinants = LogFromBelow(determinants);
    const Lanes scales = 1.0F / determinants;
    const Lanes sigmas = Sqrt(AtLeast(scales * joint.ScaledSquare(e_m), 0.0F));
    // The trace bounds the largest eigenvalue.
    const Lanes near_sigmas = moved_m * Sqrt(scales * joint.ScaledInverseTrace());
    const Lanes squared_m2 = SquaredNorm(e_m);
    // Written so that what is not a number fails.
    const LaneMask are_near = FirstLanes(landmarks.size() - i) & (determinants > 0.0F) &
                              (sigmas - near_sigmas <= gate_sigmas) &
                              (squared_m2 <= outer_m * outer_m);
    const Lanes least_sigmas = AtLeast(sigmas - near_sigmas, 0.0F);
    min_costs_.push_back(are_near ? least_sigmas * least_sigmas + log_determinants : never);
    // Only who passes the gates everywhere excludes others.
    const Lanes most_sigmas = sigmas + near_sigmas;
    const LaneMask pass =
        are_near & (most_sigmas <= gate_sigmas) & (squared_m2 <= inner_m * inner_m);
    const Lanes costs = most_sigmas * most_sigmas + log_determinants;
    max_costs = (pass & (costs < max_costs)) ? costs : max_costs;
  }
  return Least(max_costs) + kLogSlack + kCostRounding;
}

// Adds the candidates of one live point: those of which `min_costs_` are no more than `max_cost`.
template <int Dim>
void CorrespondenceFinder<Dim>::Keep(const GaussianPoint<Dim>& point,
                                     std::span<const PackedPoint<Dim>> landmarks, float max_cost) {
  const std::size_t first = candidates_.size();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const float min_cost = min_costs_[i / kLaneCount][i % kLaneCount];
    if (!std::isfinite(min_cost) || min_cost > max_cost) continue;
    const Matrix<Dim> joint = landmarks[i].Covariance_m2() + point.covariance_m2;
    const Matrix<Dim> adjugate = Adjugate<double>(joint);
    const double determinant = joint.row(0).dot(adjugate.col(0).transpose());
    candidates_.push_back({.q = landmarks[i].SeenBy(point.slant_per_m),
                           .information = adjugate / determinant,
                           .determinant = determinant});
  }
  if (candidates_.size() - first < 2) return;
  for (std::size_t i = first; i < candidates_.size(); ++i) {
    candidates_[i].log_determinant = std::log(candidates_[i].determinant);
  }
}

template class CorrespondenceFinder<2>;
template class CorrespondenceFinder<3>;

}  // namespace dcloc
