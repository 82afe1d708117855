#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/localizer/current_pose.h"
#include "core/localizer/fix_monitor.h"
#include "core/localizer/knowledge_report.h"
#include "core/localizer/localizer.h"
#include "core/localizer/localizer_snapshot.h"
#include "core/localizer/observability_schedule.h"
#include "core/localizer/radar_monitor.h"
#include "core/localizer/registration_learner.h"
#include "core/localizer/registration_schedule.h"
#include "core/localizer/reset_counter.h"
#include "core/localizer/scan_checker.h"
#include "core/localizer/stamp_monitor.h"
#include "core/localizer/time_base.h"
#include "core/localizer/tracking_state_machine.h"
#include "core/localizer/workspace.h"
#include "core/odometry/ego_motion.h"
#include "core/odometry/learned_rig.h"
#include "core/registration/map_matcher.h"
#include "core/relocalization/relocalizer.h"
#include "core/submap/submap.h"
#include "core/uncertainty/protection_level.h"

namespace dcloc {

/// The pipeline in the plane or in space. Scans are valid, are of the rig, and none comes twice.
class AnyPipeline {
 public:
  virtual ~AnyPipeline() = default;

  /// The newest scan.
  virtual Localization LocalizeNext(const Scan& scan, const TimeBase::ScanTime& time,
                                    LocalizerWorkspace& workspace, StageListener* listener) = 0;

  /// A scan from before the newest one takes part in the registrations that follow. Its pose is
  /// today's, carried back.
  virtual Localization LocalizeLate(const Scan& scan, Stamp stamp,
                                    LocalizerWorkspace& workspace) = 0;

  /// A scan that was taken nobody knows when is not used. It is answered with the pose at `newest`.
  virtual Localization LocalizeUntimed(const Scan& scan, Stamp newest) = 0;

  /// Whether the stamps of radar `index` had to be brought to the clock of the others.
  virtual void OnClock(std::size_t index, bool is_off) = 0;

  /// How far the stamp of the scan that comes next may be from when it was taken.
  virtual void OnStamp(const StampError& error) = 0;

  /// How the scan would fit the map if it were taken at `stamp`, [0, 1]. Nothing without a pose, or
  /// where the motion until then is not known.
  virtual std::optional<double> FitAt(const Scan& scan, Stamp stamp,
                                      LocalizerWorkspace& workspace) = 0;

  /// A position fix that was true at `stamp`. It is valid.
  virtual FixUse TakeFix(const InitialPose& fix, Stamp stamp) = 0;

  /// What another pipeline goes on from, but for the clocks; nothing where the pose or its sources
  /// are in doubt.
  virtual std::optional<LocalizerSnapshot> Snapshot() = 0;

  /// Goes on from a valid one. Before the first scan.
  virtual void GoOnFrom(const LocalizerSnapshot& snapshot) = 0;

  virtual bool has_pose() const = 0;
  virtual const Rig& rig() const = 0;
};

/// One vehicle's pipeline with poses in the plane of the map's keyframes (Dim = 2) or in space
/// (Dim = 3). `tracking_` says whether there is a pose; `pose_` has states exactly then.
template <int Dim>
class Pipeline final : public AnyPipeline {
 public:
  /// All arguments are valid.
  Pipeline(std::shared_ptr<const RadarMap> map, Rig rig,
           const std::optional<InitialPose>& initial_pose, const LocalizerOptions& options,
           std::shared_ptr<const RegistrationMethod<Dim>> method);

  Localization LocalizeNext(const Scan& scan, const TimeBase::ScanTime& time,
                            LocalizerWorkspace& workspace, StageListener* listener) override;
  Localization LocalizeLate(const Scan& scan, Stamp stamp, LocalizerWorkspace& workspace) override;
  Localization LocalizeUntimed(const Scan& scan, Stamp newest) override {
    Localization answer = Answer(scan, newest);
    answer.protection_level_m.reset();  // nobody knows where the vehicle was at such a stamp
    return answer;
  }
  void OnClock(std::size_t index, bool is_off) override { radar_monitor_.OnClock(index, is_off); }
  void OnStamp(const StampError& error) override { stamp_error_ = error; }
  std::optional<double> FitAt(const Scan& scan, Stamp stamp,
                              LocalizerWorkspace& workspace) override;
  FixUse TakeFix(const InitialPose& fix, Stamp stamp) override;
  std::optional<LocalizerSnapshot> Snapshot() override;
  void GoOnFrom(const LocalizerSnapshot& snapshot) override;
  bool has_pose() const override { return tracking_.has_pose(); }
  const Rig& rig() const override { return learned_rig_.rig(); }

 private:
  // A registration around the predicted pose, or at a place that was just found.
  struct Registered {
    Registration<Dim> registration;
    bool is_new_place = false;
  };

  void Start(const InitialPose& initial_pose);

  // The stages of one scan.
  void Move(const Motion& motion);
  void Compensate(const Scan& scan, Stamp stamp, const EgoVelocity& ego_velocity,
                  std::vector<RadarPoint>& points);
  bool IsTrusted(std::size_t radar_index, Stamp stamp) const {
    return dcloc::IsTrusted(radar_index, stamp, learned_rig_, radar_monitor_);
  }
  void AddToSubmap(Stamp stamp, std::size_t radar_index, const std::vector<RadarPoint>& points,
                   const Motion& motion);
  void CheckScanFit(Stamp stamp, std::size_t radar_index, Workspace<Dim>& workspace);
  void CompareSourcesByMapFit(Workspace<Dim>& workspace);
  void CompareWayRivals(Workspace<Dim>& workspace);
  void Predict(Stamp stamp, RegistrationWorkspace<Dim>& workspace);
  std::optional<Registered> Register(Stamp stamp, Workspace<Dim>& workspace);
  void UpdateObservability(const Registration<Dim>& registration, Stamp stamp,
                           Workspace<Dim>& workspace);
  RegistrationOutcome UpdatePose(const std::optional<Registered>& registered,
                                 const EgoVelocity& ego_velocity, Workspace<Dim>& workspace);
  void UpdateOdometry(const std::optional<Registered>& registered, RegistrationOutcome outcome);
  void HandleLoss(Stamp stamp);
  const RigKnowledge& Knowledge();
  Localization Answer(const Scan& scan, Stamp stamp);
  void Claim(Localization& answer);

  using Place = typename Relocalizer<Dim>::Place;
  std::optional<Place> SearchPlace(std::span<const GaussianPoint<Dim>> live, Stamp stamp,
                                   RegistrationWorkspace<Dim>& workspace);
  void EnterLocalFrame(const Eigen::Vector3d& p_map, RegistrationWorkspace<Dim>& workspace);
  PoseEstimate<3> NowInMap() const;

  LocalizerOptions options_;
  LearnedRig learned_rig_;
  RadarMonitor radar_monitor_;
  EgoMotion ego_motion_;
  SubmapWindow submap_;
  RegistrationSchedule schedule_;
  MapMatcher<Dim> matcher_;
  Relocalizer<Dim> relocalizer_;  // while there is no pose, or one that may be wrong
  CurrentPose<Dim> pose_;
  TrackingStateMachine tracking_;
  RegistrationLearner<Dim> learner_;
  ScanChecker<Dim> scan_checker_;
  WayRivals way_rivals_;
  FixMonitor fix_monitor_;
  ProtectionLevel protection_level_;
  StampError stamp_error_;  // of the newest scan
  ResetCounter reset_counter_;
  KnowledgeReport knowledge_report_;
  RigKnowledge known_;  // memory of Knowledge
  Observability observability_;
  ObservabilitySchedule observability_schedule_;
  int factor_count_ = 0;         // registrations since the pose graph was started
  LocalizationQuality quality_;  // of the newest registration that was due, and what came of it
  RegistrationOutcome newest_outcome_ = RegistrationOutcome::kNoMatch;
};

}  // namespace dcloc
