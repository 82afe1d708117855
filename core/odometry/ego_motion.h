#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/doppler_ego_velocity.h"
#include "core/odometry/late_odometry.h"
#include "core/odometry/motion.h"
#include "core/odometry/motion_history.h"
#include "core/odometry/odometry_error_filter.h"
#include "core/odometry/rig_knowledge.h"
#include "core/odometry/source_diagnosis.h"
#include "core/odometry/source_fault.h"
#include "core/odometry/source_monitor.h"
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
  /// Reported and Doppler velocity are fused where their squared Mahalanobis distance over speed
  /// and yaw rate is at most this: the chi-square quantile of 99.9 % with 2 degrees of freedom.
  double max_squared_distance = 13.8;
  /// Scans of different radars within this are of one moment.
  std::chrono::nanoseconds simultaneous = std::chrono::milliseconds(80);
  /// Deviations of the velocity while nothing is known of it.
  double unknown_speed_sigma_mps = 15.0;
  double unknown_lateral_sigma_mps = 0.5;       ///< side slip at the origin, in a curve
  double unknown_vertical_sigma_mps = 0.1;      ///< suspension
  double unknown_tilt_rate_sigma_radps = 0.05;  ///< of roll and pitch
  double unknown_yaw_rate_sigma_radps = 0.3;
  /// How far back the motion can be asked for.
  std::chrono::nanoseconds history = std::chrono::milliseconds(1500);
  /// What sound speeds and yaw rates differ by.
  double diagnosis_speed_mps = 0.5;
  double diagnosis_yaw_rate_radps = 0.02;
  /// Of a motion that was missed while a source was wrong, this fraction is its deviation.
  double missed_motion_sigma_fraction = 0.3;
};
std::span<const OptionField<EgoMotionOptions>> FieldsOf(const EgoMotionOptions& options);
absl::Status Validate(const EgoMotionOptions& options);

/// One vehicle's ego-velocity over time: what the vehicle sends fused with what its radars' Doppler
/// says, as far as `SourceMonitor` calls them sound; the last one, ever less certain, where nothing
/// is. What is constantly wrong with what the vehicle sends is learned from its poses
/// (OdometryErrorFilter).
class EgoMotion {
 public:
  /// `static_points` are those of the stage whose gate the doubt in sources widens.
  explicit EgoMotion(const EgoMotionOptions& options = {},
                     const StaticPointsOptions& static_points = {})
      : options_(options),
        errors_(options.error_filter),
        sources_(options.sources, static_points),
        late_(options.late),
        history_(options.history, options.motion),
        wheel_speed_diagnosis_(options.diagnosis_speed_mps),
        yaw_rate_diagnosis_(options.diagnosis_yaw_rate_radps) {}

  /// An earlier session found this of what the vehicle sends. Before the first scan.
  void Restore(const RigKnowledge& known);

  /// The vehicle moved so at the last scan of an earlier localizer, at `stamp`. Before the first
  /// scan; `velocity` has a covariance.
  void Restore(Stamp stamp, const EgoVelocity& velocity) {
    velocity_ = velocity;
    doubted_velocity_ = velocity;
    stamp_ = stamp;
    history_.Add(stamp, Motion{}, velocity);
  }

  /// Adds what was learned of what the vehicle sends.
  void AddTo(RigKnowledge& known) const;

  /// Takes in the next scan, taken at `stamp`, which is not before the last one's, and gives the
  /// velocity at it; the covariance is set. `radar` outlives this object, `memory` is lent for the
  /// call.
  const EgoVelocity& Advance(const Scan& scan, Stamp stamp, const RadarModel& radar,
                             EgoVelocityMemory& memory);

  /// The same by the scan's own stamp, with memory of its own.
  const EgoVelocity& Advance(const Scan& scan, const RadarModel& radar) {
    EgoVelocityMemory memory;
    return Advance(scan, scan.stamp, radar, memory);
  }

  /// A registration, accepted or an outlier, puts the vehicle here at the last scan.
  void OnRegistration(const Pose3& T_map_vehicle, const RegistrationEvidence& evidence) {
    sources_.OnRegistration(Flatten(T_map_vehicle), evidence);
    if (evidence.is_accepted) doubt_ = sources_.CurrentDoubt();
  }

  /// Where the vehicle would be now, from where it is taken to be, if other sources were sound;
  /// and how the newest scan fits the map at both places.
  std::optional<Pose3> RivalPlace() const;
  void OnFits(double fit, double rival_fit) {
    if (const auto rival = sources_.Rival()) sources_.OnFits(*rival, fit, rival_fit);
  }

  /// A registration whose scans no earlier one used puts the vehicle here at the last scan, with a
  /// covariance of (x, y, yaw): scale and yaw-rate bias are learned from it.
  void OnPose(const Pose3& T_map_vehicle, const Eigen::Matrix3d& covariance) {
    errors_.OnPose(T_map_vehicle, covariance);
  }
  /// The pose was lost: the next `OnPose` is not compared with the one before.
  void OnBreak() { errors_.OnBreak(); }
  /// The next registration is at another place: it is not compared with the one before.
  void OnPlaceChanged() { sources_.OnRegistrationLost(); }
  /// The poses given so far were wrong: scale and yaw-rate bias are estimated anew.
  void ResetErrors() { errors_ = OdometryErrorFilter(options_.error_filter); }

  /// From the scan before the last one to the last one; identity at the first. It contains what has
  /// been missed before, when a source is found to have been wrong.
  const Motion& since_previous() const { return since_previous_; }

  /// What of its covariance comes of doubt in the sources (METHOD eq 49): it is not of the noise
  /// that odometry usually has.
  const Matrix6d& doubt_since_previous() const { return doubt_since_previous_; }

  /// By how much the way since the last accepted registration may be another one [m].
  double doubted_way_m() const { return doubt_.way_bound_m; }

  /// The same without what has been missed: how an answer was expected to move on.
  const Pose3& expected_motion() const { return expected_motion_; }

  /// Whether a source was found wrong, or sound again, at the last scan.
  bool sources_changed() const { return sources_changed_; }
  const SourceMonitor& sources() const { return sources_; }

  /// By how many seconds the reported velocity is late; nothing while no delay is accepted.
  const std::optional<ScalarEstimate>& reported_delay_s() const { return late_.delay_s(); }

  /// Whether what the vehicle sends takes part in the velocity, and if not, why.
  SourceHealth wheel_speed() const;
  SourceHealth yaw_rate() const;

  /// The last velocity that the directions of radars can be held against: its yaw rate is the
  /// gyroscope's. Absent where there is none that is sound.
  const std::optional<EgoVelocity>& by_gyroscope() const { return by_gyroscope_; }

  /// At the last scan, as uncertain as the sources are doubted; nothing before the first one.
  const std::optional<EgoVelocity>& velocity() const { return doubted_velocity_; }

  /// The motion of the last moments.
  const MotionHistory& history() const { return history_; }

 private:
  struct RecentScan {
    Scan scan;
    Stamp stamp{};
    const RadarModel* radar = nullptr;
  };

  std::span<const RadarScan> Remember(const Scan& scan, Stamp stamp, const RadarModel& radar);
  EgoVelocity FromSources(const std::optional<EgoVelocity>& reported,
                          const std::optional<DopplerEgoVelocity>& doppler,
                          std::chrono::nanoseconds age) const;
  EgoVelocity FromMonitor() const;
  EgoVelocity Held(std::chrono::nanoseconds age) const;
  EgoVelocity Corrected(const EgoVelocity& reported) const;
  void Learn(const std::optional<EgoVelocity>& reported, const EgoVelocity& now,
             std::chrono::nanoseconds age);
  void AddMissedMotion();
  void AddDoubt();
  void Diagnose(const std::optional<EgoVelocity>& reported);
  SourceHealth HealthOf(OdometrySource source, const SourceDiagnosis& diagnosis) const;

  EgoMotionOptions options_;
  OdometryErrorFilter errors_;
  SourceMonitor sources_;
  LateOdometry late_;
  MotionHistory history_;
  Pose3 expected_motion_;
  Motion since_previous_;
  Matrix6d doubt_since_previous_ = Matrix6d::Zero();
  SourceMonitor::Doubt doubt_;
  std::optional<EgoVelocity> velocity_;  // if the sources that are used are sound
  std::optional<EgoVelocity> doubted_velocity_;
  // At the last scan: what the vehicle reports, corrected; without wheels that are not sound.
  std::optional<EgoVelocity> turning_;
  std::optional<EgoVelocity> by_gyroscope_;
  Stamp stamp_{};
  std::optional<Stamp> reported_stamp_;
  SourceDiagnosis wheel_speed_diagnosis_;
  SourceDiagnosis yaw_rate_diagnosis_;
  std::map<std::string, RecentScan> recent_;  // by radar id
  std::vector<RadarScan> of_one_moment_;      // the newest scan and what of recent_ is as new
  Stamp moment_{};                            // when their targets were measured, on average
  bool sources_changed_ = false;
};

}  // namespace dcloc
