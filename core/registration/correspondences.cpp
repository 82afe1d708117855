#include "core/registration/correspondences.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/registration/adjugate.h"

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

// The logarithm of a positive normal number, or up to kLogSlack less: its exponent and mantissa
// read as one number, a chord below the curve from each power of two to the next.
constexpr double kLogSlack = 0.0597;
double LogFromBelow(double value) {
  constexpr std::int64_t kOne = 0x3FF0000000000000;  // the bits of 1.0
  constexpr double kLog2 = std::numbers::ln2 / 4503599627370496.0;
  return kLog2 * static_cast<double>(std::bit_cast<std::int64_t>(value) - kOne);
}

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
          if (landmarks_.size() < count + end - begin) landmarks_.resize(2 * (count + end - begin));
          for (std::size_t index = begin; index < end; ++index) {
            const PackedPoint<Dim>& landmark = map_->points()[index];
            const VectorF<Dim> e_m = landmark.SeenBy(slant_per_m) - p;
            const VectorF<Dim> limits_m2 = gate * (landmark.Variances_m2() + variances_m2);
            bool is_near = true;
            for (int axis = 0; axis < Dim; ++axis) {
              // Negative, square included, where it may come to lie at the point itself.
              const float apart_m = std::abs(e_m(axis)) - moved_m;
              is_near &= apart_m * std::abs(apart_m) <= limits_m2(axis);
            }
            // Kept or written over by the next: branches would be guessed wrong too often.
            landmarks_[count] = static_cast<std::uint32_t>(index);
            count += is_near ? 1 : 0;
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
      Matrix<Dim> covariance = R * live_[i].covariance_m2 * R.transpose();
      covariance.diagonal().array() += blur_m * blur_m;
      WeighFor(R * live_[i].mean_m + T_local_vehicle.translation_m, covariance,
               R * live_[i].slant_per_m, std::span(landmarks_).subspan(begin, end - begin),
               kNarrow_m + kNarrow_rad * live_[i].mean_m.norm());
    }
    begin = end;
    candidates_end_.push_back(static_cast<std::uint32_t>(candidates_.size()));
  }
}

template <int Dim>
void CorrespondenceFinder<Dim>::WeighFor(const Vector<Dim>& p, const Matrix<Dim>& covariance,
                                         const Vector<Dim>& slant_per_m,
                                         std::span<const std::uint32_t> landmarks, double near_m) {
  const double gate = Squared(gates_.gate_sigmas);
  const double outer_distance_m2 = Squared(gates_.max_distance_m + near_m);
  if (weighed_.size() < landmarks.size()) weighed_.resize(2 * landmarks.size());
  std::size_t count = 0;
  for (const std::uint32_t index : landmarks) {
    const PackedPoint<Dim>& landmark = map_->points()[index];
    const Vector<Dim> q = landmark.SeenBy(slant_per_m);
    const Vector<Dim> e = q - p;
    const Matrix<Dim> joint = landmark.Covariance_m2() + covariance;
    const Matrix<Dim> adjugate = Adjugate<double>(joint);
    const double determinant = joint.row(0).dot(adjugate.col(0).transpose());
    const double scale = 1.0 / determinant;
    const double distance = scale * e.dot(adjugate * e);
    // The trace bounds the largest eigenvalue.
    const double near_distance = near_m * near_m * scale * adjugate.trace();
    Weighed& weighed = weighed_[count];
    weighed.q = q;
    weighed.information = scale * adjugate;
    weighed.determinant = determinant;
    weighed.distance = distance;
    weighed.near_distance = near_distance;
    // (a + b)^2 <= 1.2 a^2 + 6 b^2, without a root. Written so that what is not a number fails, and
    // without branches as above.
    const bool is_near = (determinant > 0.0) & (distance <= 1.2 * gate + 6.0 * near_distance) &
                         (e.squaredNorm() <= outer_distance_m2);
    count += is_near ? 1 : 0;
  }
  if (count > 1) {
    KeepUnbeaten(p, near_m, std::span(weighed_).first(count));
  } else if (count == 1) {
    candidates_.push_back({.q = weighed_[0].q, .information = weighed_[0].information});
  }
}

// Over the neighbourhood a point moves by up to `near_m`, which changes its Mahalanobis distance by
// no more than near_m over the least deviation. So the cost of each lies between bounds, and who
// cannot be better than another is left out.
template <int Dim>
void CorrespondenceFinder<Dim>::KeepUnbeaten(const Vector<Dim>& p, double near_m,
                                             std::span<Weighed> weighed) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double inner_distance_m2 = Squared(std::max(0.0, gates_.max_distance_m - near_m));
  double least_max_cost = kInfinity;
  for (Weighed& one : weighed) {
    const double log_determinant = LogFromBelow(one.determinant);
    const double sigmas = std::sqrt(one.distance);
    const double near_sigmas = std::sqrt(one.near_distance);
    one.min_cost = Squared(std::max(0.0, sigmas - near_sigmas)) + log_determinant;
    // Only who passes the gates everywhere excludes others.
    const bool passes = (sigmas + near_sigmas <= gates_.gate_sigmas) &
                        ((one.q - p).squaredNorm() <= inner_distance_m2);
    const double max_cost = Squared(sigmas + near_sigmas) + log_determinant + kLogSlack;
    least_max_cost = std::min(least_max_cost, passes ? max_cost : kInfinity);
  }
  const auto is_beaten = [&](const Weighed& one) { return one.min_cost > least_max_cost; };
  const bool is_decided = std::ranges::count_if(weighed, std::not_fn(is_beaten)) == 1;
  for (const Weighed& one : weighed) {
    if (is_beaten(one)) continue;
    candidates_.push_back({one.q, one.information, is_decided ? 0.0 : std::log(one.determinant)});
  }
}

template class CorrespondenceFinder<2>;
template class CorrespondenceFinder<3>;

}  // namespace dcloc
