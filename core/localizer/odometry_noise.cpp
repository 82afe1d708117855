#include "core/localizer/odometry_noise.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

constexpr double kForget = 0.98;     // the memory is some fifty comparisons long
constexpr double kPriorCount = 4.0;  // comparisons that the model itself is worth
constexpr double kMinRatio = 0.02;
constexpr double kMaxRatio = 9.0;
// A registration that is wrong must not stand for the wheels.
constexpr double kMaxSquaredSigmas = 9.0;

}  // namespace

template <int Dim>
void OdometryNoise<Dim>::Ratio::Add(double squared_error, double registrations, double odometry) {
  const double limit = kMaxSquaredSigmas * (registrations + odometry);
  excess = kForget * excess + std::min(squared_error, limit) - registrations;
  expected = kForget * expected + odometry;
  count = kForget * count + 1.0;
}

template <int Dim>
double OdometryNoise<Dim>::Ratio::Value() const {
  if (expected == 0.0) return 1.0;
  const double prior = kPriorCount * expected / count;
  return std::clamp((excess + prior) / (expected + prior), kMinRatio, kMaxRatio);
}

template <int Dim>
void OdometryNoise<Dim>::OnMotion(const PoseEstimate<Dim>& motion) {
  since_begin_ = {.pose = since_begin_.pose * motion.pose,
                  .covariance = ComposeCovariance<Dim>(since_begin_.covariance, motion.pose,
                                                       motion.covariance)};
}

template <int Dim>
void OdometryNoise<Dim>::OnRegistration(Stamp stamp, const PoseEstimate<Dim>& registration,
                                        std::chrono::nanoseconds span) {
  if (begin_ && stamp - begin_stamp_ <= span) return;
  if (begin_) {
    constexpr int kTurns = Pose<Dim>::kDof - Dim;
    const Pose<Dim> predicted = begin_->pose * since_begin_.pose;
    const Tangent<Dim> error = Log(predicted.Inverse() * registration.pose);
    const TangentMatrix<Dim> registrations =
        registration.covariance +
        ComposeCovariance<Dim>(begin_->covariance, since_begin_.pose, TangentMatrix<Dim>::Zero());
    const TangentMatrix<Dim>& odometry = since_begin_.covariance;
    translation_.Add(error.template head<Dim>().squaredNorm(),
                     registrations.diagonal().template head<Dim>().sum(),
                     odometry.diagonal().template head<Dim>().sum());
    rotation_.Add(error.template tail<kTurns>().squaredNorm(),
                  registrations.diagonal().template tail<kTurns>().sum(),
                  odometry.diagonal().template tail<kTurns>().sum());
  }
  begin_ = registration;
  begin_stamp_ = stamp;
  since_begin_ = {};
}

template <int Dim>
TangentMatrix<Dim> OdometryNoise<Dim>::Learned(const TangentMatrix<Dim>& covariance) const {
  Tangent<Dim> scale;
  scale.template head<Dim>().setConstant(std::sqrt(translation_.Value()));
  scale.template tail<Pose<Dim>::kDof - Dim>().setConstant(std::sqrt(rotation_.Value()));
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

template class OdometryNoise<2>;
template class OdometryNoise<3>;

}  // namespace dcloc
