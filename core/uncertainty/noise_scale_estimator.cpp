#include "core/uncertainty/noise_scale_estimator.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

// What is kept of the pairs before, of which there were so many. The memory is the newest third of
// them: the first ones are of odometry whose constant errors were not known yet.
double Kept(double pair_count, double max_forgetting_factor) {
  return std::min(max_forgetting_factor, 1.0 - 2.0 / (pair_count + 3.0));
}

template <int Dim>
PoseEstimate<Dim> Composed(const PoseEstimate<Dim>& first, const PoseEstimate<Dim>& second) {
  return {.pose = first.pose * second.pose,
          .covariance = ComposeCovariance<Dim>(first.covariance, second.pose, second.covariance)};
}

}  // namespace

std::span<const OptionField<NoiseScaleOptions>> FieldsOf(const NoiseScaleOptions& /*options*/) {
  using O = NoiseScaleOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_odometry_ratio", &O::min_odometry_ratio, 1e-9, 1},
      {"min_registration_ratio", &O::min_registration_ratio, 1e-9, 100},
      {"max_ratio", &O::max_ratio, 1, 1e6},
      {"prior_odometry_ratio", &O::prior_odometry_ratio, 1e-9, 1e6},
      {"prior_registration_ratio", &O::prior_registration_ratio, 1e-9, 1e6},
      {"prior_count", &O::prior_count, 0, 1e6, "the first pairs decide alone"},
      {"max_squared_sigmas", &O::max_squared_sigmas, 1e-6, 1e6},
      {"max_forgetting_factor", &O::max_forgetting_factor, 0, 1, "only the newest pair counts"},
      {"weight_caution", &O::weight_caution, 1e-6, 1e6},
      {"min_weight_ratio", &O::min_weight_ratio, 1e-9, 1},
  };
  return kFields;
}

absl::Status Validate(const NoiseScaleOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

template <int Dim>
void NoiseScaleEstimator<Dim>::OnMotion(const PoseEstimate<Dim>& motion) {
  since_newest_ = Composed<Dim>(since_newest_, motion);
}

template <int Dim>
void NoiseScaleEstimator<Dim>::OnRegistration(const PoseEstimate<Dim>& registration) {
  for (std::size_t i = 0; i < anchor_count_; ++i) {
    anchors_[i].to_now = Composed<Dim>(anchors_[i].to_now, since_newest_);
  }
  if (anchor_count_ > 0) Compare(anchors_.front(), registration, &Part::near);
  if (anchor_count_ == kAnchors) Compare(anchors_.back(), registration, &Part::far);
  rotation_.Solve(options_);
  translation_.Solve(options_);

  std::shift_right(anchors_.begin(), anchors_.end(), 1);
  anchors_.front() = {.registration = registration, .to_now = {}};
  anchor_count_ = std::min(anchor_count_ + 1, kAnchors);
  since_newest_ = {};
}

template <int Dim>
void NoiseScaleEstimator<Dim>::Compare(const Anchor& anchor, const PoseEstimate<Dim>& registration,
                                       Pairs Part::*pairs) {
  constexpr int kTurns = Pose<Dim>::kDof - Dim;
  const Pose<Dim> predicted = anchor.registration.pose * anchor.to_now.pose;
  const Tangent<Dim> error = Log(predicted.Inverse() * registration.pose);
  const Tangent<Dim> registrations =
      registration.covariance.diagonal() + anchor.registration.covariance.diagonal();
  const Tangent<Dim> odometry = anchor.to_now.covariance.diagonal();
  rotation_.Add(options_, rotation_.*pairs, error.template tail<kTurns>().squaredNorm(), 0.0,
                registrations.template tail<kTurns>().sum(),
                odometry.template tail<kTurns>().sum());
  // The position error at a motion's end that a heading error at its begin causes.
  TangentMatrix<Dim> turn = TangentMatrix<Dim>::Zero();
  turn.template bottomRightCorner<kTurns, kTurns>() =
      rotation_.registration_ratio *
      anchor.registration.covariance.template bottomRightCorner<kTurns, kTurns>();
  const TangentMatrix<Dim> turned =
      ComposeCovariance<Dim>(turn, anchor.to_now.pose, TangentMatrix<Dim>::Zero());
  translation_.Add(options_, translation_.*pairs, error.template head<Dim>().squaredNorm(),
                   turned.diagonal().template head<Dim>().sum(),
                   registrations.template head<Dim>().sum(), odometry.template head<Dim>().sum());
}

template <int Dim>
void NoiseScaleEstimator<Dim>::Part::Add(const NoiseScaleOptions& options, Pairs& pairs,
                                         double squared_error, double known, double registrations,
                                         double odometry) const {
  const double expected = known + registration_ratio * registrations + odometry_ratio * odometry;
  const double kept = Kept(pairs.number, options.max_forgetting_factor);
  pairs.number += 1.0;
  pairs.error =
      kept * pairs.error + std::min(squared_error, options.max_squared_sigmas * expected) - known;
  pairs.registrations = kept * pairs.registrations + registrations;
  pairs.odometry = kept * pairs.odometry + odometry;
  pairs.count = kept * pairs.count + 1.0;
  pairs.prior_count *= kept;
}

// error = registration_ratio * registrations + odometry_ratio * odometry, for near pairs and for
// far ones.
template <int Dim>
void NoiseScaleEstimator<Dim>::Part::Solve(const NoiseScaleOptions& options) {  // METHOD eq 34
  const double determinant = near.registrations * far.odometry - far.registrations * near.odometry;
  if (far.count == 0.0 || determinant <= 0.0) return;
  const double odometry =
      std::clamp((near.registrations * far.error - far.registrations * near.error) / determinant,
                 options.min_odometry_ratio, options.max_ratio);
  const double registrations =
      std::clamp((near.error - odometry * near.odometry) / near.registrations,
                 options.min_registration_ratio, options.max_ratio);
  // The prior ratios fade as the pairs do.
  const double prior = far.prior_count / (far.count + far.prior_count);
  odometry_ratio = prior * options.prior_odometry_ratio + (1.0 - prior) * odometry;
  registration_ratio = prior * options.prior_registration_ratio + (1.0 - prior) * registrations;
}

template <int Dim>
void NoiseScaleEstimator<Dim>::Part::Restore(const NoiseScaleOptions& options,
                                             const NoisePart& part) {
  static_cast<NoisePart&>(*this) = part;
  odometry_ratio = std::clamp(odometry_ratio, options.min_odometry_ratio, options.max_ratio);
  registration_ratio =
      std::clamp(registration_ratio, options.min_registration_ratio, options.max_ratio);
}

template <int Dim>
void NoiseScaleEstimator<Dim>::Restore(const NoiseKnowledge& knowledge) {
  translation_.Restore(options_, knowledge.translation);
  rotation_.Restore(options_, knowledge.rotation);
}

template <int Dim>
TangentMatrix<Dim> NoiseScaleEstimator<Dim>::Scaled(const TangentMatrix<Dim>& covariance,
                                                    double of_translation, double of_rotation) {
  Tangent<Dim> scale;
  scale.template head<Dim>().setConstant(std::sqrt(of_translation));
  scale.template tail<Pose<Dim>::kDof - Dim>().setConstant(std::sqrt(of_rotation));
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

template <int Dim>
TangentMatrix<Dim> NoiseScaleEstimator<Dim>::OdometryCovariance(
    const TangentMatrix<Dim>& covariance) const {
  return Scaled(covariance, translation_.odometry_ratio, rotation_.odometry_ratio);
}

template <int Dim>
TangentMatrix<Dim> NoiseScaleEstimator<Dim>::OdometryWeightCovariance(
    const TangentMatrix<Dim>& covariance) const {
  const auto weight = [&](const Part& part) {
    return std::clamp(options_.weight_caution * part.odometry_ratio, options_.min_weight_ratio,
                      1.0);
  };
  return Scaled(covariance, weight(translation_), weight(rotation_));
}

template <int Dim>
TangentMatrix<Dim> NoiseScaleEstimator<Dim>::RegistrationCovariance(
    const TangentMatrix<Dim>& covariance) const {
  return Scaled(covariance, translation_.registration_ratio, rotation_.registration_ratio);
}

template class NoiseScaleEstimator<2>;
template class NoiseScaleEstimator<3>;

}  // namespace dcloc
