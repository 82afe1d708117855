#pragma once

#include <array>
#include <cstddef>

#include "core/geometry/pose_estimate.h"

namespace dcloc {

/// Learns by how much odometry and registrations vary less, or more, than their covariances say:
/// good wheels are several times better than the cautious model that every vehicle gets, and
/// registrations are worse than their points promise. Registrations whose sub-maps share no scan
/// are compared by pairs with the odometry between them, near ones and far ones: what grows with
/// the way is odometry's, what does not is the registrations'.
template <int Dim>
class NoiseScaleEstimator {
 public:
  /// The vehicle moved so since the last call.
  void OnMotion(const PoseEstimate<Dim>& motion);

  /// A believed registration in the map frame, with its own covariance, of scans that no other one
  /// took.
  void OnRegistration(const PoseEstimate<Dim>& registration);

  /// Where the vehicle was is no longer believed.
  void OnJump() { anchor_count_ = 0; }

  /// `covariance` of odometry, made as large as it has turned out to be.
  TangentMatrix<Dim> OdometryCovariance(const TangentMatrix<Dim>& covariance) const;

  /// What odometry is to weigh by that has this `covariance` by its model: twice as much as it has
  /// turned out to vary by, but no more than the model says nor less than a tenth of that.
  TangentMatrix<Dim> OdometryWeightCovariance(const TangentMatrix<Dim>& covariance) const;

  /// The same of a registration.
  TangentMatrix<Dim> RegistrationCovariance(const TangentMatrix<Dim>& covariance) const;

 private:
  static constexpr std::size_t kAnchors = 6;

  // A registration, and the odometry since then.
  struct Anchor {
    PoseEstimate<Dim> registration;
    PoseEstimate<Dim> to_now;
  };

  // Sums over pairs of squared errors and of what the two covariances expect of them, of which old
  // ones fade.
  struct Pairs {
    double error = 0.0;
    double registrations = 0.0;
    double odometry = 0.0;
    double count = 0.0;
    double prior_count = 0.005;  // that the covariances' own word is worth
    double number = 0.0;         // of all pairs, which does not fade
  };

  // Of translation, or of rotation.
  struct Part {
    Pairs near;
    Pairs far;
    double odometry_ratio = 1.0;
    double registration_ratio = 3.0;

    // `known` is what of the error has another cause.
    void Add(Pairs& pairs, double squared_error, double known, double registrations,
             double odometry) const;
    void Solve();
  };

  void Compare(const Anchor& anchor, const PoseEstimate<Dim>& registration, Pairs Part::*pairs);
  static TangentMatrix<Dim> Scaled(const TangentMatrix<Dim>& covariance, double of_translation,
                                   double of_rotation);

  Part translation_;
  Part rotation_;
  std::array<Anchor, kAnchors> anchors_;  // newest first
  std::size_t anchor_count_ = 0;
  PoseEstimate<Dim> since_newest_;
};

}  // namespace dcloc
