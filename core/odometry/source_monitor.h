#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/odometry/motion.h"
#include "core/odometry/odometry_sources.h"
#include "core/odometry/scalar_estimate.h"
#include "core/odometry/source_travel.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// What a registration says of the motion before it.
struct RegistrationEvidence {
  /// Not an outlier against the estimate.
  bool is_accepted = true;
  /// It would have seen that the vehicle moved faster or slower. Between smooth walls it does not:
  /// along them it lies where the odometry in use has put it.
  bool observes_along_track = true;
  /// How old, on average, the points are that were registered. The motion in use has joined them:
  /// what it errs by is seen with a lag as long as this, METHOD eq 44.
  std::chrono::nanoseconds submap_age{0};
};

/// When a source is taken for wrong (METHOD eq 42-44).
struct SourceMonitorOptions {
  /// Sources are compared no more often than this: the noise of readings that follow one another
  /// sooner is the same.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(70);
  // Rates [1/s] at which sound sources fail, and failed ones recover. Wheel speed and yaw rate come
  // over the same bus: they fail together, or one soon after the other.
  double wheel_failure_rate_hz = 0.02;      ///< of the wheel speed alone, while both are sound
  double yaw_rate_failure_rate_hz = 0.01;   ///< of the yaw rate alone, while both are sound
  double bus_failure_rate_hz = 0.02;        ///< of both at once
  double second_bus_failure_rate_hz = 1.0;  ///< of the one, once the other has failed
  double doppler_failure_rate_hz = 0.2;     ///< of Doppler seen in few directions
  /// Doppler in up to this many directions is seen in few: one mover may fill the view.
  int narrow_direction_count = 5;
  double direction_factor = 0.5;              ///< on Doppler's rate for each further direction
  double min_doppler_failure_rate_hz = 1e-6;  ///< of Doppler, at least
  /// That Doppler has changed where it is suddenly another multiple of the wheels' speed, by as
  /// much as the wheels' scale may have changed instead.
  double doppler_scale_change_probability = 0.2;
  double knocked_radar_rate_hz = 0.01;  ///< of a single radar's that contradicts the gyroscope
  /// Of Doppler by which the vehicle stands, in the time before the first comparison: its range
  /// rates may be compensated by the ego-motion, or there may be none.
  double standing_doppler_failure_rate_hz = 0.2;
  double recovery_rate_hz = 0.3;  ///< of a failed source to become sound
  /// The time before the first comparison in which sources may have failed. For as long after it,
  /// a radar that joins the Doppler makes it a source that was not heard yet.
  std::chrono::nanoseconds start_span = std::chrono::seconds(1);
  /// Vehicles hardly drive backwards faster than this: where nothing else is known, a source that
  /// says so has the wrong sign.
  double max_reverse_speed_mps = 6.0;
  double fast_reverse_probability = 1e-2;  ///< that it does nevertheless
  /// A standing vehicle sees something that stands still in more directions than this.
  int max_unseen_direction_count = 1;
  /// Log-likelihood that it loses at each comparison in which it does not, while what it sees moves
  /// in more directions than one mover fills.
  double unseen_standing_log_likelihood = 1.0;
  /// A source is silent when its last reading is older than this.
  std::chrono::nanoseconds silent_after = std::chrono::milliseconds(500);
  // Lower bounds of the standard deviations of readings, whatever their source claims.
  double min_speed_sigma_mps = 0.15;       ///< of a speed: the constant part
  double min_speed_sigma_fraction = 0.02;  ///< of a speed: the part in proportion to it
  double min_yaw_rate_sigma_radps = 0.01;  ///< of a yaw rate
  // The process noise, per second, of each hypothesis.
  double acceleration_sigma_mps2 = 5.0;        ///< standard deviation of the speed's change
  double yaw_acceleration_sigma_radps2 = 1.0;  ///< standard deviation of the yaw rate's change
  // A failed source says nearly what it said before, or anything.
  double speed_range_mps = 60.0;      ///< width of the range of speeds that are "anything"
  double yaw_rate_range_radps = 2.0;  ///< width of the range of yaw rates that are "anything"
  double unchanged_fraction = 0.9;    ///< probability of nearly the same as before
  // A hypothesis without readings becomes less certain, up to these standard deviations.
  double unknown_speed_sigma_mps = kUnknownSpeedSigma_mps;  ///< of its speed
  double silent_yaw_rate_sigma_radps = 0.5;                 ///< of its yaw rate
  /// Probability, at each comparison, that the motion is unlike any prediction and a hypothesis's
  /// filter has to start anew.
  double restart_probability = 1e-6;
  /// By how much less probable than without it a hypothesis with a gyroscope is that has repeated
  /// itself since it was found wrong, in log-probability.
  double stuck_log_ratio = 7.0;
  /// No hypothesis falls further below the best one than this, in log-probability, so that it can
  /// recover.
  double max_log_ratio = 40.0;
  /// Hypotheses within this of the best one, in log-probability, dispute the motion that is used:
  /// an accepted registration takes from them what it sees. Others it refutes.
  double disputed_log_ratio = 6.0;
  /// Hypotheses within this of the best one, in log-probability, widen the variance of the speed
  /// and the yaw rate.
  double spread_log_ratio = 7.0;
  /// Hypotheses less probable than this, beside the best one, are no part of the spread.
  double min_probability_ratio = 1e-4;
  /// Scans compare an alternative that puts the vehicle at least this far along-track from where it
  /// is taken to be.
  double min_alternative_distance_m = 0.4;
  double min_alternative_turn_rad = 0.05;  ///< or that has turned it by so much otherwise
  /// Log-likelihood that a hypothesis gains by a fit that is better by 1.
  double log_likelihood_per_fit = 10.0;
  /// The shortest time between two registrations that are compared.
  std::chrono::nanoseconds min_registered_interval = std::chrono::milliseconds(500);
  /// The longest time between two registrations that are compared.
  std::chrono::nanoseconds max_registered_interval = std::chrono::milliseconds(3000);
  /// Registrations that differ by more, in log-likelihood, between hypotheses that are not
  /// improbable have told: the next ones count besides.
  double decisive_log_ratio = 2.0;
  double registered_sigma_m = 0.15;     ///< std. dev. of one registration's position along-track
  double registered_sigma_rad = 0.004;  ///< std. dev. of one registration's heading
  double false_registration_fraction = 0.02;  ///< share of the registrations that are false
  /// The most probable sources are tried for this long without an accepted registration. Then the
  /// next ones are tried: with wrong ones no scan may be registered that could show it.
  std::chrono::nanoseconds trial_span = std::chrono::milliseconds(3500);
  /// Each trial takes twice as long as the one before, up to this many spans.
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
  /// A speed of fewer deviations than this may be none.
  static constexpr double kStandingSigmas = 3.0;

  /// The gate of `static_points` is what the spread of the speed has to widen.
  explicit SourceMonitor(const SourceMonitorOptions& options = {},
                         const StaticPointsOptions& static_points = {});

  /// Takes in what the sources say at `stamp`, which is not before the last one.
  void OnReadings(Stamp stamp, const OdometryReadings& readings);

  /// Doppler, which is sound, has told another scale of the wheels, by which the vehicle is
  /// `forward_m` from where it was taken to be at the last readings. If Doppler errs, it is not.
  void OnDopplersScaleChange(double forward_m);

  /// A registration puts the vehicle here at the last readings. It is compared with one before, be
  /// it an outlier against the estimate or not: the estimate is made of the sources. An accepted
  /// registration clears the unapplied correction, as far as it sees it.
  void OnRegistration(const Pose2& T_map_vehicle, const RegistrationEvidence& evidence);
  /// It is no longer known where the vehicle was.
  void OnRegistrationLost() {
    registered_.reset();
    scale_reference_.reset();
  }

  /// Which sources are sound, most probably.
  OdometrySources sound() const { return best().sound; }
  bool IsSound(OdometrySource source) const { return Contains(sound(), source); }

  bool AllSound() const {
    return IsSound(OdometrySource::kWheelSpeed) && IsSound(OdometrySource::kYawRate) &&
           IsSound(OdometrySource::kDoppler);
  }

  /// Whether each hypothesis by which `source` is sound is improbable beside the best one.
  bool IsRuledOut(OdometrySource source) const;

  /// Whether each hypothesis by which it is not sound is improbable.
  bool IsCertain(OdometrySource source) const;

  /// Probability of `sound()`, [0, 1].
  double confidence() const;

  /// Speed [m/s] and yaw rate [rad/s] by the sound sources, with the spread of what other
  /// hypotheses say that are not improbable.
  ScalarEstimate speed() const { return Mixed(&Hypothesis::speed); }
  ScalarEstimate yaw_rate() const { return Mixed(&Hypothesis::yaw_rate); }

  /// Reports the motion that the pose used between the last two readings [m, rad]. If the set of
  /// sound sources has changed since the last call, returns the correction to apply: the motion by
  /// the new set, minus what was used, as far as no accepted registration has seen it.
  std::optional<ArcMotion> OnUsedMotion(double forward_m, double turn_rad);

  /// The model spread: how the hypotheses that are probable differ from the motion that was used,
  /// as far as no accepted registration has seen it, and from the velocity now. Zero while they
  /// agree.
  struct Spread {
    /// With it, the gate of static targets reaches those of each motion that is as probable as the
    /// best one, and of others as far as they are probable [m2/s2].
    double speed_variance = 0.0;
    double yaw_rate_variance = 0.0;        ///< [rad2/s2]
    double along_track_variance_m2 = 0.0;  ///< about the motion that was used
    double turn_variance_rad2 = 0.0;
    double along_track_bound_m = 0.0;  ///< the most that a hypothesis differs by along-track
    double turn_bound_rad = 0.0;       ///< and the most by which it has turned otherwise
  };
  Spread CurrentSpread() const;

  /// The most probable other motion, besides the one that was used, that is not improbable and puts
  /// the vehicle elsewhere or has turned it otherwise. Nothing too soon after the
  /// last `OnFits` of radar `radar_index`: what radars see of one moment counts for each of them.
  std::optional<ArcMotion> Alternative(std::size_t radar_index) const;

  /// How a scan of that radar at the last readings fits the map, [0, 1]: `fit` where the vehicle is
  /// by the motion that was used, `alternative_fit` where `alternative` puts it. `alternative` is
  /// what `Alternative` returned for these readings.
  void OnFits(std::size_t radar_index, const ArcMotion& alternative, double fit,
              double alternative_fit);

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
    ArcMotion unapplied;             // beyond the motion that was used
    ArcMotion unseen;                // of that, what registrations do not see yet
    ArcMotion since_registered;      // the motion that registrations see
    double since_reference_m = 0.0;  // along-track, since `scale_reference_`
    double log_evidence = 0.0;       // that it has added to the weight

    // Since the last call, by the means of both ends: half a second apart, they may differ by much.
    ArcMotion MotionIn(double duration_s) {
      const ArcMotion motion{0.5 * (previous_speed_mps + speed.value) * duration_s,
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
  Transitions TransitionsIn(double duration_s, int direction_count,
                            double min_doppler_failure_rate_hz) const;
  static double LogTransition(const OdometrySources& before, const OdometrySources& after,
                              const Transitions& transitions);
  Hypothesis MostProbablePredecessor(const OdometrySources& sound, double duration_s,
                                     const Transitions& transitions) const;
  bool SaysStanding(const std::optional<ScalarEstimate>& speed) const;
  OdometryReadings WithFloors(const OdometryReadings& readings) const;
  void Update(Hypothesis& hypothesis, const OdometryReadings& readings, double duration_s) const;
  static Hypothesis ByShareOfDoppler(const Hypothesis& before, const OdometryReadings& readings);
  // One that contradicts the gyroscope may have been knocked, and sees as much as before.
  static bool MayBeKnocked(const OdometryReadings& readings) {
    return readings.single_radar && readings.single_radar->beyond_gyroscope_radps > 0.0;
  }
  static void UpdateBySingleRadar(Hypothesis& hypothesis, const SingleRadarReading& reading);
  void Begin(const OdometryReadings& readings);
  bool Joins(Stamp stamp, const OdometryReadings& readings);
  void ForgetStates();
  void DoubtFastReverse();
  void DoubtStanding(const OdometryReadings& readings);
  void TryOthers(Stamp stamp, const OdometryReadings& readings);
  void OnSourcesFit(Stamp stamp);
  // Whether it is open if Doppler has told the right scale of the wheels.
  bool ScaleIsOpen() const { return before_.doppler_multiple != 1.0; }
  ArcMotion BesideBest(const Hypothesis& hypothesis) const;
  double Apart(const ArcMotion& a, const ArcMotion& b) const;
  bool MeasuresDifference(const Hypothesis& hypothesis, const ArcMotion& difference) const;
  void SeeMotion(const RegistrationEvidence& evidence);
  void CompareScales(const Pose2& T_map_vehicle, const RegistrationEvidence& evidence);
  void CompareWithReference(const Pose2& T_map_vehicle);
  bool HasDecided() const;
  void CompareWithRegistration(const Pose2& T_map_vehicle, const RegistrationEvidence& evidence);
  void DoubtStuckYawRate();
  void Normalize();

  SourceMonitorOptions options_;
  double static_gate_mps_;
  double static_gate_sigmas_;
  Hypotheses hypotheses_;
  std::size_t best_ = kHypothesisCount - 1;
  OdometrySources used_;  // sound at the last OnUsedMotion
  OdometryReadings before_;
  bool yaw_rate_is_stuck_ = false;  // repeated, and found wrong since it is
  LastReported last_reported_;
  std::optional<Stamp> began_;           // when they were compared first
  std::size_t doppler_radar_count_ = 0;  // the most so far
  std::optional<Stamp> compared_;        // when the readings were last compared
  std::optional<Stamp> newest_;          // of all readings
  double since_used_s_ = 0.0;
  // Sum of (dt^2 / 8)^2 since the registration that is compared next: what a vehicle that speeds up
  // by 1 in a second does between readings dt apart, unseen (as of METHOD eq 23).
  double unseen_s4_ = 0.0;
  std::vector<std::optional<Stamp>> fits_compared_;  // by radar
  std::optional<Stamp> newest_registered_;
  std::optional<Registered> registered_;
  struct ScaleReference {
    Stamp stamp;
    Pose2 T_map_vehicle;
    double unseen_s4;
  };
  std::optional<ScaleReference> scale_reference_;  // the registration that scales are compared with
  // When a registration last spoke for the best hypothesis, or its trial began, and for how many
  // spans.
  std::optional<Stamp> accepted_or_tried_;
  int trial_count_ = 1;
  SourceTravel travel_;  // since registrations last fitted the sources, or all of these each other
};

}  // namespace dcloc
