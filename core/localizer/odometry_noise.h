#pragma once

#include <chrono>
#include <optional>

#include "core/posegraph/state_chain.h"
#include "core/radar/scan.h"

namespace dcloc {

/// Learns by how much odometry varies less, or more, than its covariance says: good wheels are
/// several times better than the cautious model that every vehicle gets. Two registrations whose
/// sub-maps share no scan are compared with the odometry between them; what they do not account for
/// themselves is odometry's.
template <int Dim>
class OdometryNoise {
 public:
  /// The vehicle moved so since the last call.
  void OnMotion(const PoseEstimate<Dim>& motion);

  /// A believed registration in the map frame, with its own covariance, of scans over `span`.
  void OnRegistration(Stamp stamp, const PoseEstimate<Dim>& registration,
                      std::chrono::nanoseconds span);

  /// Where the vehicle was is no longer believed.
  void OnJump() { begin_.reset(); }

  /// `covariance` of odometry, made as large as it has turned out to be.
  TangentMatrix<Dim> Learned(const TangentMatrix<Dim>& covariance) const;

 private:
  // Squared errors that are odometry's, over what its covariance expects.
  struct Ratio {
    double excess = 0.0;
    double expected = 0.0;
    double count = 0.0;

    void Add(double squared_error, double registrations, double odometry);
    double Value() const;
  };

  Ratio translation_;
  Ratio rotation_;
  std::optional<PoseEstimate<Dim>> begin_;  // in the map frame
  PoseEstimate<Dim> since_begin_;
  Stamp begin_stamp_{};
};

}  // namespace dcloc
