#pragma once

#include <array>
#include <bitset>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/pose.h"
#include "core/localizer/health.h"
#include "core/localizer/localization_state.h"
#include "core/localizer/localizer_options.h"
#include "core/localizer/localizer_snapshot.h"
#include "core/localizer/pose_resets.h"
#include "core/localizer/position_fix.h"
#include "core/localizer/workspace.h"
#include "core/map/radar_map.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"
#include "core/registration/registration_method.h"
#include "core/relocalization/initial_pose.h"
#include "core/uncertainty/beta_monitor.h"

namespace dcloc {

/// How good one answer is; inliers are those of the newest registration, which need not be this
/// scan's.
struct LocalizationQuality {
  int live_point_count = 0;     ///< static points in the sub-map
  int inlier_count = 0;         ///< live points that matched a landmark
  double overlap = 0.0;         ///< matched fraction of the live points, [0, 1]
  double residual_scale = 0.0;  ///< root mean square of the whitened residuals; 1 is as modelled
  /// Squared Mahalanobis distance between the registration and its prediction (METHOD eq 19).
  double normalized_innovation_squared = 0.0;
  /// Its absolute pose factor passed the gate, began the pose graph anew, or made the alternative
  /// chain the accepted one.
  bool is_accepted = false;
  BetaCheck beta;  ///< of the scan's radar
};

/// The answer to one scan.
struct Localization {
  Stamp stamp;
  LocalizationState state = LocalizationState::kInitializing;
  Pose3 T_map_vehicle;
  /// In the tangent space on the right of `T_map_vehicle`.
  Matrix6d covariance = Matrix6d::Zero();
  /// Degrees of freedom (x, y, z, roll, pitch, yaw) of the vehicle frame that radar observed: not
  /// the vertical ones by planar radars, and not along-track between smooth walls.
  std::bitset<6> observed;
  /// The horizontal position is off by no more than this, but for once in ten thousand times
  /// (METHOD eq 56). Absent where nothing is promised, as always where the state is not tracking.
  std::optional<double> protection_level_m;
  Health health;
  PoseResets resets;
  LocalizationQuality quality;
  /// All that was learned of the rig; absent unless it has changed since it was last reported.
  std::optional<RigKnowledge> learned;
};

/// The stages of one scan, in order (the paper's Table V).
enum class Stage { kCompensation, kSubmap, kRegistration, kPoseGraph };
inline constexpr std::array<const char*, 4> kStageNames = {"compensation", "submap", "registration",
                                                           "posegraph"};

/// Is called when a stage of a scan begins. core has no clock: a caller that wants times reads one
/// here.
class StageListener {
 public:
  virtual ~StageListener() = default;
  virtual void OnStageBegin(Stage stage) = 0;
};

/// One vehicle's localization in one map. Not thread-safe; different vehicles are independent.
/// Deterministic: the same map, options and scans give bit-identical answers.
class Localizer {
 public:
  /// Without an `initial_pose` the whole map is searched. InvalidArgument names what is wrong with
  /// the map (null), the rig, the pose or the options. `methods` replace our registration.
  static absl::StatusOr<Localizer> Create(std::shared_ptr<const RadarMap> map, Rig rig,
                                          const std::optional<InitialPose>& initial_pose,
                                          const LocalizerOptions& options = {},
                                          const RegistrationMethods& methods = {});
  Localizer(Localizer&&) noexcept;
  Localizer& operator=(Localizer&&) noexcept;
  ~Localizer();

  /// Localizes one scan. A late scan is used at its stamp, and a repeated one is answered from
  /// memory. InvalidArgument for an invalid scan, an unknown radar, or a stamp that lies more than
  /// `time_base.max_lateness` before the newest scan. The pose then stays as it was; several such
  /// stamps in a row mean that the clock was set back (METHOD 17). `workspace` is lent for the
  /// call.
  absl::StatusOr<Localization> Localize(const Scan& scan, LocalizerWorkspace& workspace,
                                        StageListener* listener = nullptr);

  /// The same with a workspace of its own, which it keeps.
  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener = nullptr);

  /// Takes in what something else than radar says of the pose, between two scans. It can start and
  /// guide a search, weighs as it is certain, and forces no pose that the radars contradict.
  /// InvalidArgument names what is no pose or no covariance; then nothing has changed.
  absl::StatusOr<FixUse> TakeFix(const PositionFix& fix);

  /// What another localizer of the same vehicle, rig and map goes on from, after the newest scan.
  /// Nothing while the vehicle is not tracked and has not been since it was found, and while a
  /// source of its odometry is set aside.
  std::optional<LocalizerSnapshot> Snapshot();

  /// Restores the snapshot of an earlier localizer. To be called before the first scan; the
  /// scans that follow are those after the snapshot's. InvalidArgument names what is wrong with it;
  /// then nothing has changed.
  absl::Status Restore(const LocalizerSnapshot& snapshot);

  /// Whether there is a pose that registrations start from. While there is none, scans search the
  /// map, for about ten milliseconds each. A pose that is doubted, lost or from an unverified prior
  /// counts: scans then register, and may search beside it to hold it against other places.
  bool has_pose() const;

  /// The radars as they are known by now: as described, or corrected by what they measure.
  const Rig& rig() const;

 private:
  struct Impl;
  explicit Localizer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
  std::unique_ptr<LocalizerWorkspace> own_workspace_;
};

}  // namespace dcloc
