#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/localizer/localizer.h"
#include "core/localizer/tracking_state.h"
#include "core/odometry/ego_motion.h"
#include "core/posegraph/pose_hypotheses.h"
#include "core/registration/map_matcher.h"
#include "core/relocalization/global_localizer.h"
#include "core/relocalization/pose_prior.h"
#include "core/submap/submap.h"
#include "core/uncertainty/beta_monitor.h"
#include "core/uncertainty/noise_scale_estimator.h"

namespace dcloc {

/// What Localizer holds: the pipeline in the plane or in space.
class Localizer::Impl {
 public:
  virtual ~Impl() = default;
  virtual absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) = 0;
  virtual bool searching() const = 0;
};

/// One vehicle's pipeline with poses in the plane of the map's keyframes (Dim = 2) or in space
/// (Dim = 3).
template <int Dim>
class Pipeline final : public Localizer::Impl {
 public:
  Pipeline(std::shared_ptr<const RadarMap> map, Rig rig,
           const std::optional<InitialPose>& initial_pose, const LocalizerOptions& options);

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) override;
  bool searching() const override { return graph_.empty(); }

 private:
  absl::Status CheckOrder(const Scan& scan) const;
  void Start(const InitialPose& initial_pose);
  void PushScan(const Scan& scan, const RadarModel& radar, const Motion& motion);
  bool RegistrationIsDue(Stamp stamp) const;
  void EnterLocalFrame(const Eigen::Vector3d& p_map);
  void HandleLoss(Stamp stamp);
  void InflateCovariance(Matrix6d& covariance);
  std::optional<Registration<Dim>> Find(std::span<const GaussianPoint<Dim>> live, Stamp stamp);
  std::optional<Registration<Dim>> Register(std::span<const GaussianPoint<Dim>> live, Stamp stamp);
  void Learn(const std::optional<Registration<Dim>>& registration, const EgoVelocity& ego_velocity,
             Stamp stamp);
  void UpdateObservability(const Registration<Dim>& registration, Stamp stamp);
  EdgeTest UpdateGraph(const Registration<Dim>& registration, const EgoVelocity& ego_velocity,
                       Stamp stamp);
  PoseEstimate<Dim> Now() const;
  TangentMatrix<Dim> Uncertainty() const;
  PoseEstimate<Dim> OdometryEdge() const;
  TangentMatrix<Dim> NoiseSinceState() const;
  Localization Answer(const Scan& scan);

  Rig rig_;
  LocalizerOptions options_;
  EgoMotion ego_motion_;
  SubmapWindow window_;
  MapMatcher<Dim> matcher_;
  GlobalLocalizer<Dim>
      global_localizer_;  // while nothing is known that registrations can start from
  PoseHypotheses<Dim> graph_;
  TrackingState state_;
  PosePrior pose_prior_;  // while it is looked for
  NoiseScaleEstimator<Dim> noise_scales_;
  BetaMonitor<Dim> beta_monitor_;
  Observability observability_;
  std::optional<Stamp> observability_stamp_;
  Motion since_state_;       // from the graph's newest state to the newest scan
  bool was_silent_ = false;  // since then
  std::optional<Stamp> last_stamp_;
  Stamp window_begin_{};  // of the first scan since the window was empty
  std::optional<Stamp> last_registration_;
  int scans_since_registration_ = 0;
  std::optional<Stamp> last_learned_;  // of registrations without a common scan
  std::map<std::string, Stamp> last_stamp_of_radar_;
  int registration_count_ = 0;  // believed, since the graph was started
  LocalizationQuality quality_;
};

}  // namespace dcloc
