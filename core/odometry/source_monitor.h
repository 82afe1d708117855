#pragma once

#include <array>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/odometry/motion.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// What says how the vehicle moves.
enum class OdometrySource : std::size_t { kWheelSpeed, kYawRate, kDoppler };
inline constexpr std::size_t kOdometrySourceCount = 3;

/// A set of sources, by their number.
using OdometrySources = std::bitset<kOdometrySourceCount>;

/// What the sources say at one moment; those that are silent are absent. Speeds are forward, of the
/// vehicle frame's origin [m/s]; yaw rates counter-clockwise [rad/s].
struct OdometryReadings {
  std::optional<ScalarEstimate> wheel_speed;
  std::optional<ScalarEstimate> yaw_rate;
  std::optional<ScalarEstimate> doppler_speed;  ///< there exactly when doppler_yaw_rate is
  std::optional<ScalarEstimate> doppler_yaw_rate;
  /// What the targets say that contradict those of `doppler_speed`, where they agree among
  /// themselves: of the two, one is a convoy's, and the hypotheses choose.
  std::optional<ScalarEstimate> alternative_speed;
  std::optional<ScalarEstimate> alternative_yaw_rate;  ///< there exactly when both others are
  /// How many directions, ten degrees wide, the Doppler's inliers lie in: one mover that fills the
  /// view is seen in few.
  int doppler_direction_count = 0;
};

/// What a registration says of the motion before it.
struct RegistrationEvidence {
  /// Not an outlier against the estimate.
  bool is_accepted = true;
  /// It would have seen that the vehicle moved faster or slower. Between smooth walls it does not:
  /// along them it lies where the odometry in use has put it.
  bool observes_along_track = true;
};

/// When a source is taken for wrong (METHOD eq 42-44).
struct SourceMonitorOptions {
  /// Sources are compared no more often than this: the noise of readings that follow one another
  /// sooner is the same.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(70);
  /// How often a sound source fails, and a failed one comes back, per second. Wheel speed and yaw
  /// rate come over the same bus: they fail together, or one soon after the other.
  double wheel_failure_rate_hz = 0.02;
  double yaw_rate_failure_rate_hz = 0.01;
  double bus_failure_rate_hz = 0.02;
  double second_bus_failure_rate_hz = 1.0;
  /// One mover that fills the view is seen in few directions. Doppler from so many fails at this
  /// rate, and by this factor less often for each further one.
  double doppler_failure_rate_hz = 0.2;
  int narrow_direction_count = 5;
  double direction_factor = 0.5;
  double min_doppler_failure_rate_hz = 1e-6;
  double recovery_rate_hz = 0.3;
  /// Sources may have failed in so long before the first comparison.
  std::chrono::nanoseconds start_span = std::chrono::seconds(1);
  /// What the vehicle sent is silent when it is older than this.
  std::chrono::nanoseconds silent_after = std::chrono::milliseconds(500);
  /// Deviations that no source is better than, whatever it claims.
  double min_speed_sigma_mps = 0.15;
  double min_speed_sigma_fraction = 0.02;
  double min_yaw_rate_sigma_radps = 0.01;
  /// How the vehicle may change its motion in a second.
  double acceleration_sigma_mps2 = 5.0;
  double yaw_acceleration_sigma_radps2 = 1.0;
  /// What a failed source may say: anything within this, or nearly what it said before.
  double speed_range_mps = 60.0;
  double yaw_rate_range_radps = 2.0;
  double unchanged_fraction = 0.9;
  /// What a hypothesis whose sources are silent knows of the motion; it becomes no less certain.
  double unknown_speed_sigma_mps = kUnknownSpeedSigma_mps;
  double silent_yaw_rate_sigma_radps = 0.5;
  /// Probability, at each comparison, that the motion is unlike any prediction and a hypothesis's
  /// filter has to start anew.
  double restart_probability = 1e-6;
  /// Log-probability ratios to the best hypothesis. None falls below the first, so that it can
  /// recover. Those within the second widen the variance of the motion.
  double max_log_ratio = 40.0;
  double spread_log_ratio = 7.0;
  /// Hypotheses less probable than this, beside the best one, are no part of the spread.
  double min_probability_ratio = 1e-4;
  /// Scans tell hypotheses apart that put the vehicle so far from one another. A fit that is better
  /// by 1 makes a hypothesis more probable by so much, in log-likelihood.
  double min_alternative_distance_m = 0.4;
  double log_likelihood_per_fit = 10.0;
  /// Registrations that are compared lie at least so far apart, and err by so much.
  std::chrono::nanoseconds min_registered_interval = std::chrono::milliseconds(500);
  std::chrono::nanoseconds max_registered_interval = std::chrono::milliseconds(3000);
  double registered_sigma_m = 0.15;
  double registered_sigma_rad = 0.004;
  double false_registration_fraction = 0.02;
  /// Where nothing has been registered for so long, the next most probable sources are tried: wrong
  /// ones let no scan be registered that could tell.
  std::chrono::nanoseconds trial_span = std::chrono::milliseconds(3500);
  /// Each trial takes twice as long as the one before, up to so many spans.
  int max_trial_spans = 4;
};
std::span<const OptionField<SourceMonitorOptions>> FieldsOf(const SourceMonitorOptions& options);
absl::Status Validate(const SourceMonitorOptions& options);

/// Holds the sources of odometry against one another and against registrations, and says which of
/// them to use. No source has a rank: a hypothesis for each set of sources that may be sound
/// follows the vehicle's speed and yaw rate by a Kalman filter of its own, and is as probable as it
/// predicted what its sources said. A source that is not sound may say anything, but most often
/// nearly the same as before. Sources fail and recover at stated rates; of the hypotheses that lead
/// to one set the most probable goes on.
class SourceMonitor {
 public:
  /// The gate of `static_points` is what the spread of the speed has to widen.
  explicit SourceMonitor(const SourceMonitorOptions& options = {},
                         const StaticPointsOptions& static_points = {});

  /// Takes in what the sources say at `stamp`, which is not before the last one.
  void OnReadings(Stamp stamp, const OdometryReadings& readings);

  /// A registration puts the vehicle here at the last readings. It is compared with one before, be
  /// it an outlier against the estimate or not: the estimate is made of the sources. What was not
  /// applied before an accepted one never will be.
  void OnRegistration(const Pose2& T_map_vehicle, const RegistrationEvidence& evidence);
  /// It is no longer known where the vehicle was.
  void OnRegistrationLost() { registered_.reset(); }

  /// Which sources are sound, most probably.
  OdometrySources sound() const { return best().sound; }
  bool IsSound(OdometrySource source) const { return sound()[static_cast<std::size_t>(source)]; }

  /// Probability of `sound()`, [0, 1].
  double confidence() const;

  /// Speed [m/s] and yaw rate [rad/s] by the sound sources, with the spread of what other
  /// hypotheses say that are not improbable.
  ScalarEstimate speed() const { return Mixed(&Hypothesis::speed); }
  ScalarEstimate yaw_rate() const { return Mixed(&Hypothesis::yaw_rate); }

  /// The vehicle's motion since the readings before the last ones was taken to be this. Gives the
  /// correction to apply, where the sound sources are no longer those of the call before: how the
  /// vehicle moved since the last accepted registration by the ones that are sound now, beyond what
  /// was used.
  struct PlanarMotion {
    double forward_m = 0.0;
    double turn_rad = 0.0;
  };
  std::optional<PlanarMotion> OnUsedMotion(double forward_m, double turn_rad);

  /// The model spread: how the hypotheses that are probable differ from the motion that was used
  /// since a registration was last accepted, and from the velocity now. Zero while they agree.
  struct Spread {
    /// With it, the gate of static targets reaches those of each motion that is as probable as the
    /// best one, and of others as far as they are probable [m2/s2].
    double speed_variance = 0.0;
    double yaw_rate_variance = 0.0;        ///< [rad2/s2]
    double along_track_variance_m2 = 0.0;  ///< about the motion that was used
    double turn_variance_rad2 = 0.0;
    double along_track_bound_m = 0.0;  ///< the most that a hypothesis differs by along-track
  };
  Spread CurrentSpread() const;

  /// The most probable other motion, besides the one that was used since a registration was last
  /// accepted, that is not improbable and puts the vehicle elsewhere. Nothing too soon after the
  /// last `OnFits`.
  std::optional<PlanarMotion> Alternative() const;

  /// A scan at the last readings fits the map so well, [0, 1], where the vehicle is by the motion
  /// that was used, and so well where the alternative puts it.
  void OnFits(const PlanarMotion& alternative, double fit, double alternative_fit);

 private:
  // Which sources are sound, and how the vehicle moves if so.
  struct Hypothesis {
    OdometrySources sound;
    double log_weight = 0.0;
    ScalarEstimate speed;
    ScalarEstimate yaw_rate;
    // At the last OnUsedMotion.
    double previous_speed_mps = 0.0;
    double previous_yaw_rate_radps = 0.0;
    PlanarMotion unapplied;         // beyond the motion that was used
    PlanarMotion since_registered;  // the whole motion

    // Since the last call, by the means of both ends: half a second apart, they may differ by much.
    PlanarMotion MotionIn(double duration_s) {
      const PlanarMotion motion{0.5 * (previous_speed_mps + speed.value) * duration_s,
                                0.5 * (previous_yaw_rate_radps + yaw_rate.value) * duration_s};
      previous_speed_mps = speed.value;
      previous_yaw_rate_radps = yaw_rate.value;
      return motion;
    }
  };
  static constexpr std::size_t kHypothesisCount = 1U << kOdometrySourceCount;
  using Hypotheses = std::array<Hypothesis, kHypothesisCount>;
  // Log-probabilities of what happens at a rate, or not, in some time.
  struct Change {
    Change(double rate_hz, double duration_s);
    double log_stay;
    double log_change;
  };
  struct Transitions {
    Change wheel_failure;
    Change yaw_rate_failure;
    Change bus_failure;
    Change second_bus_failure;
    Change doppler_failure;
    Change recovery;
  };
  struct Registered {
    Stamp stamp;
    Pose2 T_map_vehicle;
    bool observes_along_track;
  };
  // When each quantity was last reported.
  struct LastReported {
    std::optional<Stamp> wheel_speed;
    std::optional<Stamp> yaw_rate;
    std::optional<Stamp> doppler_speed;
    std::optional<Stamp> doppler_yaw_rate;
  };

  const Hypothesis& best() const { return hypotheses_[best_]; }
  // Whether one of its sound sources has reported within `silent_after`.
  bool MeasuresSpeed(const Hypothesis& hypothesis) const;
  bool MeasuresYawRate(const Hypothesis& hypothesis) const;
  ScalarEstimate Mixed(ScalarEstimate Hypothesis::*of) const;
  Transitions TransitionsIn(double duration_s, int direction_count) const;
  static double LogTransition(const OdometrySources& before, const OdometrySources& after,
                              const Transitions& transitions);
  Hypothesis MostProbablePredecessor(const OdometrySources& sound, double duration_s,
                                     const Transitions& transitions) const;
  OdometryReadings WithFloors(const OdometryReadings& readings) const;
  void Update(Hypothesis& hypothesis, const OdometryReadings& readings, double duration_s) const;
  void Begin(const OdometryReadings& readings);
  void TryOthers(Stamp stamp, const OdometryReadings& readings);
  void CompareWithRegistration(const Pose2& T_map_vehicle, const RegistrationEvidence& evidence);
  void Normalize();

  SourceMonitorOptions options_;
  double static_gate_mps_;
  double static_gate_sigmas_;
  Hypotheses hypotheses_;
  std::size_t best_ = kHypothesisCount - 1;
  OdometrySources used_;  // sound at the last OnUsedMotion
  OdometryReadings before_;
  LastReported last_reported_;
  std::optional<Stamp> compared_;  // when the readings were last compared
  std::optional<Stamp> newest_;    // of all readings
  double since_used_s_ = 0.0;
  // Sum of (dt^2 / 8)^2 since the registration that is compared next: what a vehicle that speeds up
  // by 1 in a second does between readings dt apart, unseen (as of METHOD eq 23).
  double unseen_s4_ = 0.0;
  std::optional<Stamp> fits_compared_;
  std::optional<Registered> registered_;
  // When a registration last spoke for the best hypothesis, or its trial began, and for how many
  // spans.
  std::optional<Stamp> accepted_or_tried_;
  int trial_count_ = 1;
};

}  // namespace dcloc
