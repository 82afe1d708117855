#pragma once

#include <chrono>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"

namespace dcloc {

/// How a delay is looked for, and when it is accepted (METHOD eq 45).
struct OdometryDelayOptions {
  /// Delays that are compared: from -`earliest_steps` to `latest_steps` steps. A negative one is
  /// that of a vehicle whose radars stamp their scans too early.
  std::chrono::nanoseconds step = std::chrono::milliseconds(50);
  int earliest_steps = 3;
  int latest_steps = 9;
  /// Half the width of the triangle by which reported velocities are weighed around a moment:
  /// one that lies between two of them must not look less noisy than one that lies on one.
  std::chrono::nanoseconds smoothing = std::chrono::milliseconds(150);
  /// Doppler moments that follow one another sooner share their noise.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(70);
  /// The time constant with which older moments lose weight: one of this age weighs 1 / e.
  std::chrono::nanoseconds time_constant = std::chrono::seconds(20);
  /// A delay is accepted where its log-likelihood ratio to no delay is at least this. It is given
  /// up below half of it.
  double min_log_likelihood = 25.0;
  int min_moment_count = 40;  ///< Doppler moments that must have been compared before
  /// The shortest delay that is accepted. One that was accepted is given up below half of it.
  std::chrono::nanoseconds min_delay = std::chrono::milliseconds(35);
  /// No pair of signals agrees better than this: steps of quantised ones.
  double speed_floor_mps = 0.02;
  double yaw_rate_floor_radps = 0.002;
  /// A delay that an earlier session found is no more certain than this.
  double prior_sigma_s = 0.02;
};
std::span<const OptionField<OdometryDelayOptions>> FieldsOf(const OdometryDelayOptions& options);
absl::Status Validate(const OdometryDelayOptions& options);

/// Finds by how much later than its stamp the reported velocity was true: the delay at which it
/// explains the radars' Doppler best. For each of some delays it keeps the regression of Doppler on
/// the reported velocity of that moment, for speed and yaw rate, so that neither a scale nor a bias
/// is taken for a delay.
class OdometryDelayEstimator {
 public:
  explicit OdometryDelayEstimator(const OdometryDelayOptions& options);

  /// An earlier session found this delay. It holds until this drive says otherwise.
  void Restore(const ScalarEstimate& delay_s);

  /// The vehicle reports this speed [m/s] and yaw rate [rad/s] at `stamp`, which is not before the
  /// last one.
  void OnReported(Stamp stamp, double speed_mps, double yaw_rate_radps);

  /// Doppler that is sound says this of `stamp`.
  void OnDoppler(Stamp stamp, double speed_mps, double yaw_rate_radps);

  /// By how many seconds the reported velocity is late, and the variance of that. Nothing while no
  /// delay is accepted.
  const std::optional<ScalarEstimate>& delay_s() const { return delay_s_; }

 private:
  struct Sample {
    Stamp stamp;
    double speed_mps;
    double yaw_rate_radps;
  };
  /// Of y on x; sums of older pairs count less.
  struct Regression {
    double weight = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    double x_last = 0.0, y_last = 0.0;                   // of the newest pair
    double xx_next = 0.0, xy_next = 0.0, yy_next = 0.0;  // of each pair with the one before it

    void Add(double keep, double x_new, double y_new);
    double Slope() const;
    double ResidualVariance() const;
    /// Residuals that resemble their neighbours inform less than as many independent ones: by this
    /// factor, (1 - r) / (1 + r) of their correlation r.
    double IndependentFraction() const;
  };
  struct Candidate {
    Regression speed;
    Regression yaw_rate;
  };

  std::chrono::nanoseconds DelayOf(int candidate) const {
    return (candidate - options_.earliest_steps) * options_.step;
  }
  std::optional<Sample> ReportedAt(Stamp stamp) const;
  void Compare(const Sample& doppler);
  void Decide();
  double Cost(std::size_t candidate, double speed_count, double yaw_rate_count) const;
  std::size_t LeastCost(double speed_count, double yaw_rate_count) const;

  OdometryDelayOptions options_;
  std::vector<Candidate> candidates_;
  std::vector<Sample> reported_then_;  // by candidate; memory of Compare
  std::vector<Sample> reported_;       // the newest last
  std::vector<Sample> waiting_;        // Doppler of which not all candidates are known yet
  std::optional<Stamp> last_doppler_, last_compared_;
  int moment_count_ = 0;
  std::optional<ScalarEstimate> prior_s_;
  double prior_weight_ = 0.0;
  std::optional<ScalarEstimate> delay_s_;
};

}  // namespace dcloc
