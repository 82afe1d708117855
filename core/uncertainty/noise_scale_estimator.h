#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose_estimate.h"
#include "core/options/option_fields.h"
#include "core/uncertainty/noise_knowledge.h"

namespace dcloc {

/// Bounds and priors of the learned ratios between actual and modelled variances.
struct NoiseScaleOptions {
  double min_odometry_ratio = 0.0005;
  double min_registration_ratio = 1.0;  ///< never smaller than the covariance from their points
  double max_ratio = 25.0;
  double prior_odometry_ratio = 1.0;
  double prior_registration_ratio = 3.0;
  double prior_count = 0.005;  ///< weight of the prior ratios, in pairs
  /// Upper bound of a pair's squared error, in units of its expectation: a wrong registration
  /// changes neither ratio.
  double max_squared_sigmas = 9.0;
  /// Weight that older pairs keep: about fifty count, at first the newest third.
  double max_forgetting_factor = 0.98;
  /// Odometry is weighted by its learned variance times `weight_caution`, but by at least
  /// `min_weight_ratio` of its model's variance.
  double weight_caution = 2.0;
  double min_weight_ratio = 0.1;
};
std::span<const OptionField<NoiseScaleOptions>> FieldsOf(const NoiseScaleOptions& options);
absl::Status Validate(const NoiseScaleOptions& options);

/// Learns the ratio of the actual variance to the modelled one, for odometry and for registrations.
/// Good wheels are several times better than the cautious model that every vehicle gets;
/// registrations are worse than the covariance from their points. Pairs of registrations whose
/// sub-maps share no scan are compared with the odometry between them, near pairs and far pairs.
/// Error that grows with the distance driven is odometry's, the rest is the registrations' (METHOD
/// eq 34).
template <int Dim>
class NoiseScaleEstimator {
 public:
  explicit NoiseScaleEstimator(const NoiseScaleOptions& options = {})
      : options_(options), translation_(options), rotation_(options) {}

  /// The motion since the last call.
  void OnMotion(const PoseEstimate<Dim>& motion);

  /// An accepted registration in the map frame, with its own covariance. It shares no scan with the
  /// others that are passed.
  void OnRegistration(const PoseEstimate<Dim>& registration);

  /// The pose was lost or odometry interrupted: later registrations are not compared with earlier
  /// ones.
  void OnDiscontinuity() { anchor_count_ = 0; }

  /// What was learned so far.
  NoiseKnowledge knowledge() const { return {translation_, rotation_}; }

  /// An earlier estimator of the same vehicle learned this. Its ratios are brought within the
  /// bounds of the options. Before the first registration.
  void Restore(const NoiseKnowledge& knowledge);

  /// `covariance` of odometry by its model, scaled by the learned ratio.
  TangentMatrix<Dim> OdometryCovariance(const TangentMatrix<Dim>& covariance) const;

  /// Covariance by which odometry is weighted: the learned one times `weight_caution`, but at most
  /// the model's `covariance` and at least `min_weight_ratio` of it.
  TangentMatrix<Dim> OdometryWeightCovariance(const TangentMatrix<Dim>& covariance) const;

  /// As OdometryCovariance, of a registration.
  TangentMatrix<Dim> RegistrationCovariance(const TangentMatrix<Dim>& covariance) const;

 private:
  static constexpr std::size_t kAnchors = 6;  // a far pair is this many sub-maps apart

  // A registration, and the odometry since then.
  struct Anchor {
    PoseEstimate<Dim> registration;
    PoseEstimate<Dim> to_now;
  };

  using Pairs = NoisePairs;

  // Of translation, or of rotation.
  struct Part : NoisePart {
    explicit Part(const NoiseScaleOptions& options)
        : NoisePart{.near = {.prior_count = options.prior_count},
                    .far = {.prior_count = options.prior_count},
                    .odometry_ratio = options.prior_odometry_ratio,
                    .registration_ratio = options.prior_registration_ratio} {}

    // `known` is what of the error has another cause.
    void Add(const NoiseScaleOptions& options, Pairs& pairs, double squared_error, double known,
             double registrations, double odometry) const;
    void Solve(const NoiseScaleOptions& options);
    void Restore(const NoiseScaleOptions& options, const NoisePart& part);
  };

  void Compare(const Anchor& anchor, const PoseEstimate<Dim>& registration, Pairs Part::*pairs);
  static TangentMatrix<Dim> Scaled(const TangentMatrix<Dim>& covariance, double of_translation,
                                   double of_rotation);

  NoiseScaleOptions options_;
  Part translation_;
  Part rotation_;
  std::array<Anchor, kAnchors> anchors_;  // newest first
  std::size_t anchor_count_ = 0;
  PoseEstimate<Dim> since_newest_;
};

}  // namespace dcloc
