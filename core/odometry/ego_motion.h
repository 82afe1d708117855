#pragma once

#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/chi_square.h"
#include "core/odometry/doppler_ego_velocity.h"
#include "core/odometry/forward_acceleration.h"
#include "core/odometry/held_velocity.h"
#include "core/odometry/late_odometry.h"
#include "core/odometry/motion.h"
#include "core/odometry/motion_history.h"
#include "core/odometry/odometry_error_filter.h"
#include "core/odometry/odometry_errors.h"
#include "core/odometry/repeated_yaw_rate.h"
#include "core/odometry/rig_knowledge.h"
#include "core/odometry/single_radar_yaw_rate.h"
#include "core/odometry/source_diagnosis.h"
#include "core/odometry/source_fault.h"
#include "core/odometry/source_monitor.h"
#include "core/odometry/speed_disagreement.h"
#include "core/odometry/wheel_scale_monitor.h"
#include "core/odometry/yaw_rate_sign.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/radar/static_points.h"

namespace dcloc {

struct EgoMotionOptions {
  EgoVelocityOptions doppler;
  MotionOptions motion;
  OdometryErrorFilterOptions error_filter;
  SourceMonitorOptions sources;
  LateOdometryOptions late;
  WheelScaleMonitorOptions wheel_scale;
  SpeedDisagreementOptions disagreement;
  ForwardAccelerationOptions acceleration;
  /// Reported and Doppler velocity are fused where their squared Mahalanobis distance over speed
  /// and yaw rate is at most this.
  double max_squared_distance = kChiSquare999With2Dof;
  /// Scans of different radars within this are of one moment.
  std::chrono::nanoseconds simultaneous = std::chrono::milliseconds(80);
  // Standard deviations of the velocity while nothing is known of it.
  double unknown_speed_sigma_mps = kUnknownSpeedSigma_mps;  ///< forward
  double unknown_lateral_sigma_mps = 0.5;                   ///< side slip at the origin, in a curve
  double unknown_vertical_sigma_mps = 0.1;                  ///< suspension
  double unknown_tilt_rate_sigma_radps = 0.05;              ///< of roll and pitch
  double unknown_yaw_rate_sigma_radps = 0.3;                ///< of yaw
  /// How far back the motion can be asked for.
  std::chrono::nanoseconds history = std::chrono::milliseconds(1500);
  /// A velocity that is repeated is old once Doppler has moved on from it by this.
  double max_held_distance_m = 0.15;
  double diagnosis_speed_mps = 0.5;        ///< speeds that differ by no more agree
  double diagnosis_yaw_rate_radps = 0.02;  ///< yaw rates that differ by no more agree
  /// The deviation of the correction that is applied when a source is found wrong, as a fraction of
  /// it.
  double correction_sigma_fraction = 0.3;
};
std::span<const OptionField<EgoMotionOptions>> FieldsOf(const EgoMotionOptions& options);
absl::Status Validate(const EgoMotionOptions& options);

/// One vehicle's ego-velocity over time: what the vehicle sends fused with what its radars' Doppler
/// says, as far as `SourceMonitor` calls them sound; the last one, ever less certain, where nothing
/// is. What is constantly wrong with what the vehicle sends is learned from its poses
/// (OdometryErrorFilter).
class EgoMotion {
 public:
  /// `static_points` are those of the stage whose gate the spread of the sources widens.
  explicit EgoMotion(const EgoMotionOptions& options = {},
                     const StaticPointsOptions& static_points = {})
      : options_(options),
        errors_(options.error_filter),
        sources_(options.sources, static_points),
        late_(options.late),
        wheel_scale_(options.wheel_scale),
        disagreement_(options.disagreement),
        acceleration_(options.acceleration),
        history_(options.history, options.motion),
        wheel_speed_diagnosis_(options.diagnosis_speed_mps),
        yaw_rate_diagnosis_(options.diagnosis_yaw_rate_radps) {}

  /// An earlier session found this of what the vehicle sends. Before the first scan.
  void Restore(const RigKnowledge& known);

  /// The vehicle moved so at the last scan of an earlier localizer, at `stamp`. Before the first
  /// scan; `velocity` has a covariance.
  void Restore(Stamp stamp, const EgoVelocity& velocity) {
    velocity_ = velocity;
    widened_velocity_ = velocity;
    stamp_ = stamp;
    history_.Add(stamp, Motion{}, velocity);
  }

  /// Adds what was learned of what the vehicle sends.
  void AddTo(RigKnowledge& known) const;

  /// Takes in the next scan, taken at `stamp`, which is not before the last one's, and gives the
  /// velocity at it; the covariance is set. `radar` outlives this object, `workspace` is lent for
  /// the call.
  const EgoVelocity& Advance(const Scan& scan, Stamp stamp, const RadarModel& radar,
                             EgoVelocityWorkspace& workspace);

  /// The same by the scan's own stamp, with memory of its own.
  const EgoVelocity& Advance(const Scan& scan, const RadarModel& radar) {
    EgoVelocityWorkspace workspace;
    return Advance(scan, scan.stamp, radar, workspace);
  }

  /// A registration, accepted or an outlier, puts the vehicle here at the last scan.
  void OnRegistration(const Pose3& T_map_vehicle, const RegistrationEvidence& evidence) {
    sources_.OnRegistration(Flatten(T_map_vehicle), evidence);
    if (!evidence.is_accepted) return;
    spread_ = sources_.CurrentSpread();
    if (evidence.observes_along_track) unobserved_distance_m_ = 0.0;
  }

  /// Where the vehicle would be now if other sources were sound.
  struct AlternativePlace {
    ArcMotion motion;          ///< beyond the motion that was used
    Pose3 T_used_alternative;  ///< the same as a pose
  };
  /// The most probable such place; see SourceMonitor::Alternative.
  std::optional<AlternativePlace> Alternative(std::size_t radar_index) const;
  /// How the newest scan fits the map, [0, 1], where the vehicle is taken to be and at the place
  /// that `Alternative` has returned.
  void OnFits(std::size_t radar_index, const AlternativePlace& alternative, double fit,
              double alternative_fit) {
    sources_.OnFits(radar_index, alternative.motion, fit, alternative_fit);
  }

  /// A registration whose scans no earlier one used puts the vehicle here at the last scan, with a
  /// covariance of (x, y, yaw) [m, rad] in the tangent space on the right: scale and yaw-rate bias
  /// are learned from it.
  void OnPose(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance) {
    errors_.OnPose(T_map_vehicle, covariance);
  }
  /// The pose is doubted: see OdometryErrorFilter::OnDoubt. One that was not doubted before may
  /// have been led astray by a velocity that is repeated.
  void OnPoseDoubted(bool was_confirmed) {
    errors_.OnDoubt();
    if (was_confirmed) held_velocity_.OnContradicted();
  }
  /// The next registration is at another place: it is not compared with the one before.
  void OnPlaceChanged() {
    sources_.OnRegistrationLost();
    errors_.OnDiscontinuity();
  }
  /// The mount of this radar has been corrected.
  void OnMountCorrected(const std::string& radar_id) {
    recent_[radar_id].yaw_rate.OnMountChanged();
  }
  /// The range rates of a radar are corrected otherwise from now on. What Doppler has told of the
  /// wheels is of no account.
  void OnRangeRatesCorrected() {
    errors_.OnDopplersSoundness(/*is_sound=*/false, /*is_certain=*/true);
    wheel_scale_.ForgetRatio();
  }
  /// The poses given so far were wrong: scale and yaw-rate bias are estimated anew.
  void ResetErrors() {
    errors_ = OdometryErrors(options_.error_filter);
    wheel_scale_.TellScaleAgain();
  }

  /// From the scan before the last one to the last one; identity at the first. Where a source is
  /// found to have been wrong, it contains the correction of what that made of earlier scans.
  const Motion& since_previous() const { return since_previous_; }

  /// The part of its covariance that is the spread of the sources (METHOD eq 49), and not the noise
  /// that odometry usually has.
  const Matrix6d& spread_since_previous() const { return spread_since_previous_; }

  /// The most by which a probable set of sources differs along-track from the motion that was used,
  /// as far as no registration has seen it [m]: b_along of METHOD eq 49.
  double along_track_spread_m() const { return spread_.along_track_bound_m; }

  /// The most by which such a set differs in how far the vehicle has turned [rad].
  double turn_spread_rad() const { return spread_.turn_bound_rad; }

  /// By how far wheels and Doppler have moved apart along-track while nothing says which of them is
  /// right [m].
  double undecided_distance_m() const { return std::abs(disagreement_.distance_m()); }

  /// `since_previous` without a correction: an answer was expected to move on by this, and what it
  /// moves beyond is a reset.
  const Pose3& expected_motion() const { return expected_motion_; }

  /// Whether a source was found wrong, or sound again, at the last scan.
  bool sources_changed() const { return sources_changed_; }
  const SourceMonitor& sources() const { return sources_; }

  /// Whether what the vehicle sends takes part in the velocity, and if not, why.
  SourceHealth wheel_speed() const;
  SourceHealth yaw_rate() const;

  /// Speed of the sound sources, yaw rate of the gyroscope: the reference for mount yaw,
  /// independent of Doppler azimuths. Absent while the gyroscope is silent or faulty.
  const std::optional<EgoVelocity>& velocity_for_mounts() const { return velocity_for_mounts_; }

  /// At the last scan, as uncertain as the sources differ; nothing before the first one.
  const std::optional<EgoVelocity>& velocity() const { return widened_velocity_; }

  /// Whether the vehicle counts its yaw rate in the other direction. Scans are to be given with
  /// the right one.
  bool yaw_rate_is_reversed() const { return yaw_rate_sign_.is_reversed(); }

  /// The motion of the last moments.
  const MotionHistory& history() const { return history_; }

 private:
  struct RecentScan {
    Scan scan;
    Stamp stamp{};
    const RadarModel* radar = nullptr;
    SingleRadarYawRate yaw_rate = {};
  };

  std::span<const RadarScan> Remember(const Scan& scan, Stamp stamp, const RadarModel& radar);
  std::optional<SingleRadarReading> YawRateBesideGyroscope(
      const RadarModel& radar, const std::optional<EgoVelocity>& reported,
      const std::optional<DopplerEgoVelocity>& doppler);
  EgoVelocity FromSources(const std::optional<EgoVelocity>& reported,
                          const std::optional<DopplerEgoVelocity>& doppler,
                          std::chrono::nanoseconds age) const;
  double WheelSpeedNow_mps(const EgoVelocity& late) const;
  bool WheelsLeap(const EgoVelocity& reported, const EgoVelocity& doppler) const;
  EgoVelocity FromMonitor() const;
  EgoVelocity Held(std::chrono::nanoseconds age) const;
  EgoVelocity Corrected(const EgoVelocity& reported, const OdometryErrorFilter& errors) const;
  void Learn(const std::optional<EgoVelocity>& reported, const EgoVelocity& now,
             std::chrono::nanoseconds age);
  void FollowWheelScale(Stamp stamp, const std::optional<EgoVelocity>& reported,
                        const DopplerEgoVelocity* doppler);
  // Whether what the vehicle reports is old: nothing is to be learned of it.
  bool is_held() const { return held_velocity_.age() > options_.sources.silent_after; }
  // Whether the motion is the one that the vehicle reports.
  bool follows_reports() const {
    return sources_.IsSound(OdometrySource::kWheelSpeed) &&
           sources_.IsSound(OdometrySource::kYawRate) && !wheels_leap_;
  }
  // Whether sources that may be sound turn the vehicle at different rates.
  bool YawRateIsDisputed() const {
    return std::sqrt(spread_.yaw_rate_variance) > options_.diagnosis_yaw_rate_radps;
  }
  void FollowYawRateSign(const std::optional<EgoVelocity>& reported,
                         const DopplerEgoVelocity* doppler);
  void AddHeldSpread();
  void ApplyCorrection();
  void Correct(double forward_m, double turn_rad);
  void AddSpread();
  void Diagnose(const std::optional<EgoVelocity>& reported);
  SourceHealth HealthOf(OdometrySource source, const SourceDiagnosis& diagnosis) const;

  EgoMotionOptions options_;
  OdometryErrors errors_;
  SourceMonitor sources_;
  LateOdometry late_;
  WheelScaleMonitor wheel_scale_;
  SpeedDisagreement disagreement_;
  ForwardAcceleration acceleration_;
  YawRateSign yaw_rate_sign_;
  HeldVelocity held_velocity_;
  RepeatedYawRate repeated_yaw_rate_;
  bool wheels_leap_ = false;                 // at the last scan, while Doppler goes on
  std::chrono::nanoseconds outdated_by_{0};  // the newest velocity, where Doppler is newer
  MotionHistory history_;
  Pose3 expected_motion_;
  Motion since_previous_;
  Matrix6d spread_since_previous_ = Matrix6d::Zero();
  SourceMonitor::Spread spread_;
  std::optional<EgoVelocity> velocity_;  // if the sources that are used are sound
  std::optional<EgoVelocity> widened_velocity_;
  // At the last scan: what the vehicle reports, corrected; wheels that are not sound are replaced.
  std::optional<EgoVelocity> reported_with_sound_wheels_;
  std::optional<EgoVelocity> velocity_for_mounts_;
  Stamp stamp_{};
  std::optional<Stamp> reported_stamp_;
  SourceDiagnosis wheel_speed_diagnosis_;
  SourceDiagnosis yaw_rate_diagnosis_;
  std::map<std::string, RecentScan> recent_;    // by radar id
  std::vector<RadarScan> simultaneous_scans_;   // those of recent_ within `simultaneous`
  std::vector<std::chrono::nanoseconds> ages_;  // of each
  Stamp moment_{};                              // when their targets were measured, on average
  bool sources_changed_ = false;
  // Driven since a registration last said where along the track the vehicle is.
  double unobserved_distance_m_ = 0.0;
  double scale_correction_m_ = 0.0;  // to be applied to the motion
  double reversed_turn_rad_ = 0.0;   // by a sign of the yaw rate that was found to be wrong
};

}  // namespace dcloc
