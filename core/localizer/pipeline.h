#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>

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
#include "core/online_calibration/learned_rig.h"
#include "core/online_calibration/range_rate_errors.h"
#include "core/online_calibration/range_rate_offsets.h"
#include "core/radar/repeated_targets.h"
#include "core/registration/map_matcher.h"
#include "core/relocalization/relocalizer.h"
#include "core/submap/submap.h"
#include "core/uncertainty/along_track_rivals.h"
#include "core/uncertainty/azimuth_signs.h"
#include "core/uncertainty/place_evidence.h"
#include "core/uncertainty/protection_level.h"
#include "core/uncertainty/range_biases.h"

namespace dcloc {

/// The pipeline in the plane or in space. Scans are valid, are of the rig, and none comes twice.
class AnyPipeline {
 public:
  virtual ~AnyPipeline() = default;

  /// The newest scan.
  virtual Localization LocalizeNext(const Scan& sent, const TimeBase::ScanTime& time,
                                    LocalizerWorkspace& workspace, StageListener* listener) = 0;

  /// A scan from before the newest one takes part in the registrations that follow. Its pose is
  /// the newest one, carried back by odometry; its state is that of the newest pose.
  virtual Localization LocalizeLate(const Scan& scan, Stamp stamp,
                                    LocalizerWorkspace& workspace) = 0;

  /// A scan that lies `lead` ahead of all others is not used: its radar's clock leapt, or else all
  /// radars were silent. It is answered with the pose at `newest`, which is as uncertain as the way
  /// that `lead` would make, and without a protection level.
  virtual Localization LocalizeUntimed(const Scan& scan, Stamp newest,
                                       std::chrono::nanoseconds lead) = 0;

  /// Reports whether the clock of radar `index` is off, so that its stamps had to be corrected.
  virtual void ReportClockOffset(std::size_t index, bool is_off) = 0;

  /// How far the stamp of the scan that comes next may be from when it was taken.
  virtual void OnStamp(const StampError& error) = 0;

  /// How a scan fits the map, [0, 1], and what that says.
  struct TriedFit {
    double fit = 0.0;
    ScanFit verdict = ScanFit::kUnknown;
  };
  /// The same of a scan if it were taken at `stamp`. Nothing without a pose, or where the motion
  /// until then is not known.
  virtual std::optional<TriedFit> TryFit(const Scan& scan, Stamp stamp,
                                         LocalizerWorkspace& workspace) = 0;

  /// A position fix that was true at `stamp`. It is valid.
  virtual FixUse TakeFix(const InitialPose& fix, Stamp stamp) = 0;

  /// State to resume from, without clock offsets: Localizer adds them. Nothing while the pose or a
  /// source is doubted.
  virtual std::optional<LocalizerSnapshot> Snapshot() = 0;

  /// Restores a valid one. Before the first scan.
  virtual void Restore(const LocalizerSnapshot& snapshot) = 0;

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

  Localization LocalizeNext(const Scan& sent, const TimeBase::ScanTime& time,
                            LocalizerWorkspace& workspace, StageListener* listener) override;
  Localization LocalizeLate(const Scan& scan, Stamp stamp, LocalizerWorkspace& workspace) override;
  Localization LocalizeUntimed(const Scan& scan, Stamp newest,
                               std::chrono::nanoseconds lead) override;
  void ReportClockOffset(std::size_t index, bool is_off) override {
    radars_.monitor.ReportClockOffset(index, is_off);
  }
  void OnStamp(const StampError& error) override { radars_.stamp_error = error; }
  std::optional<TriedFit> TryFit(const Scan& scan, Stamp stamp,
                                 LocalizerWorkspace& workspace) override;
  FixUse TakeFix(const InitialPose& fix, Stamp stamp) override;
  std::optional<LocalizerSnapshot> Snapshot() override;
  void Restore(const LocalizerSnapshot& snapshot) override;
  bool has_pose() const override { return tracking_.has_pose(); }
  const Rig& rig() const override { return radars_.learned.rig(); }

 private:
  // A registration around the predicted pose, or at a place that was just found.
  struct Registered {
    Registration<Dim> registration;
    PlaceOrigin origin = PlaceOrigin::kExpected;
  };

  void Start(const InitialPose& initial_pose);

  void RestoreKnown(const RigKnowledge& known);

  // The stages of one scan.
  void LearnRig(const Scan& scan, Stamp stamp, std::size_t radar_index);
  Motion MotionSincePrevious(bool clock_was_set) const;
  void Move(const Motion& motion);
  // Leaves the static points in the workspace.
  void Compensate(const Scan& scan, Stamp stamp, const EgoVelocity& ego_velocity,
                  Workspace<Dim>& workspace);
  bool IsTrusted(std::size_t radar_index, Stamp stamp) const {
    return dcloc::IsTrusted(radar_index, stamp, radars_.learned, radars_.monitor);
  }
  void AddToSubmap(Stamp stamp, std::size_t radar_index, const std::vector<RadarPoint>& points,
                   const Motion& motion);
  void TestScanFit(Stamp stamp, std::size_t radar_index, Workspace<Dim>& workspace);
  void TestLateScanFit(Stamp stamp, std::size_t radar_index, const MotionHistory::Moment& moment,
                       Workspace<Dim>& workspace);
  ScanFit TakeScanFit(Stamp stamp, std::size_t radar_index, const PoseEstimate<Dim>& pose,
                      Workspace<Dim>& workspace);
  void TakePlaceEvidence(Stamp stamp, std::size_t radar_index, const Pose<Dim>& pose,
                         const Workspace<Dim>& workspace);
  void UpdateTrackingByScanFit(ScanFit fit);
  void CompareSourcesByMapFit(std::size_t radar_index, Workspace<Dim>& workspace);
  void CompareAlongTrackRivals(std::size_t radar_index, ScanFit fit, Workspace<Dim>& workspace);
  void RegisterAlongTrackRivals(double pose_score, Workspace<Dim>& workspace);
  // Whether the sign has changed: then the scan's points are dropped.
  bool LearnAzimuthSign(std::size_t radar_index, Workspace<Dim>& workspace);
  void TryOtherAzimuthSigns();
  void TryOtherRangeBiases();
  void GuessRangeBiases();
  void OnAzimuthSignChanged(std::size_t radar_index);
  void OnRangeCorrected(std::size_t radar_index);
  // Whether ranges have been corrected: then the scan's points are dropped.
  bool LearnRangeBias(Stamp stamp, std::size_t radar_index, Workspace<Dim>& workspace);
  // `sent`, without targets that its radar sent before.
  const Scan& Fresh(const Scan& sent, std::size_t radar_index, Workspace<Dim>& workspace);
  void LearnRangeRateOffset(const Scan& scan, Stamp stamp, std::size_t radar_index);
  // `scan` itself, or a copy in `workspace` with the sign of azimuths, the scale and the offset of
  // range rates that were learned.
  const Scan& Corrected(const Scan& scan, Workspace<Dim>& workspace) const;
  // `scan`, without targets where its range rates do not tell the motion.
  const Scan& TellingMotion(const Scan& scan, Workspace<Dim>& workspace) const;
  // `scan`, with what the ego-motion adds to compensated range rates.
  const Scan& AsMeasured(const Scan& scan, const EgoVelocity& ego_velocity,
                         Workspace<Dim>& workspace) const;
  void RegisterSubmap(Stamp stamp, const EgoVelocity& ego_velocity, Workspace<Dim>& workspace,
                      StageListener* listener);
  void ExpireTimeouts(Stamp stamp);
  void Predict(Stamp stamp, RegistrationWorkspace<Dim>& workspace);
  std::optional<Registered> Register(Stamp stamp, Workspace<Dim>& workspace);
  void UpdateObservability(const Registration<Dim>& registration, Stamp stamp,
                           Workspace<Dim>& workspace);
  RegistrationOutcome UpdatePose(Stamp stamp, const std::optional<Registered>& registered,
                                 const EgoVelocity& ego_velocity, Workspace<Dim>& workspace);
  void UpdateOdometry(const std::optional<Registered>& registered, RegistrationOutcome outcome);
  void GiveUpFailedPose(Stamp stamp);
  FixUse FuseFix(const PoseEstimate<3>& T_map_vehicle);
  const RigKnowledge& Knowledge();
  // Of the answers: a jump of the pose since the last one counts as a reset, and what was learned
  // since it was last reported goes along.
  Localization FinishScan(const Scan& scan, Stamp stamp);
  Localization Answer(const Scan& scan, Stamp stamp) const;
  void Claim(Localization& answer) const;
  double AlongTrackSpread_m() const;
  double ClaimedPositionSigma(const Matrix6d& covariance, double speed_mps) const;

  using Place = typename Relocalizer<Dim>::Place;
  std::optional<Place> SearchPlace(std::span<const GaussianPoint<Dim>> live, Stamp stamp,
                                   RegistrationWorkspace<Dim>& workspace);
  void OnSearchedInVain(Stamp stamp);
  void OnPoseVerified(bool fits_as_usual);
  void EnterLocalFrame(const Eigen::Vector3d& p_map, RegistrationWorkspace<Dim>& workspace);
  bool IsVague() const;
  PoseEstimate<3> NowInMap() const;
  // Where the vehicle was at a moment of its history, as certain as it is now.
  PoseEstimate<Dim> PoseThen(const MotionHistory::Moment& moment) const;

  struct RangeTrial {
    std::chrono::nanoseconds duration;
    Stamp end;
  };
  // The radars as they are known by now, and how far each is trusted.
  struct Radars {
    Radars(Rig described, const LocalizerOptions& options, const MapInfo& map)
        : learned(std::move(described), options.learned_rig),
          monitor(learned.rig().radars.size(), options.radar_monitor),
          repeated_targets(learned.rig().radars.size()),
          azimuth_signs(learned.rig().radars.size(), options.azimuth_signs),
          range_biases(learned.rig().radars.size(), options.range_biases),
          range_rate_errors(learned.rig().radars.size(), options.range_rate_errors),
          range_rate_offsets(learned.rig().radars.size(), options.range_rate_offsets),
          scan_checker(learned.rig().radars.size(), options.map_fit) {
      if (map.stamp_delay_s) learned.BeginToLearnStamps(*map.stamp_delay_s);
    }

    LearnedRig learned;
    RadarMonitor monitor;
    RepeatedTargets repeated_targets;
    AzimuthSigns azimuth_signs;
    RangeBiases range_biases;
    RangeRateErrors range_rate_errors;
    RangeRateOffsets range_rate_offsets;
    ScanChecker<Dim> scan_checker;
    std::optional<RangeTrial> range_trial;  // of their biases, since nothing was found
    StampError stamp_error;                 // of the newest scan
    double restamped_s = 0.0;  // by how much time offsets changed at the newest scan, at most
  };
  // The source cloud, and when it is registered.
  struct LiveScans {
    SubmapWindow submap;
    RegistrationSchedule schedule;
  };
  // The target cloud, and what the newest registration that was asked observes in it.
  struct MapAround {
    MapMatcher<Dim> matcher;
    Observability observability = {};
    ObservabilitySchedule observability_schedule = {};
  };
  // The newest registration that was due, and what came of it.
  struct NewestRegistration {
    LocalizationQuality quality = {};
    RegistrationOutcome outcome = RegistrationOutcome::kNoMatch;
  };
  // What answers need beside the pose and its state.
  struct Claims {
    ProtectionLevel protection_level;
    // By how much the next answer may correct the newest one.
    double expected_change_m = std::numeric_limits<double>::infinity();
    ResetCounter reset_counter;
    KnowledgeReport knowledge_report;
    RigKnowledge known = {};  // memory of Knowledge
  };

  LocalizerOptions options_;
  Radars radars_;
  EgoMotion ego_motion_;
  LiveScans live_;
  MapAround map_;
  Relocalizer<Dim> relocalizer_;  // while there is no pose, or one that may be wrong
  TrackingStateMachine tracking_;
  CurrentPose<Dim> pose_;
  int registration_count_ = 0;  // since the pose graph was started, outliers too
  NewestRegistration newest_;
  RegistrationLearner<Dim> learner_;
  AlongTrackRivals rivals_;
  PlaceEvidence place_evidence_;
  FixMonitor fix_monitor_;
  Claims claims_;
};

}  // namespace dcloc
