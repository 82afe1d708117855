#include "core/localizer/pipeline.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"
#include "core/uncertainty/calibration_covariance.h"
#include "core/uncertainty/registration_factor.h"

namespace dcloc {
namespace {

constexpr int kDofInSpace = 6;
constexpr double kUnknownVariance = 1e8;  // of a pose that nothing is known of

StaticPointsOptions PointOptions(const LocalizerOptions& options) {
  StaticPointsOptions points = options.static_points;
  points.compensate = options.doppler_compensation;
  points.uncertainty = options.uncertainty;
  return points;
}

PoseGraphOptions GraphOptions(const LocalizerOptions& options) {
  PoseGraphOptions graph = options.pose_graph;
  graph.gate_outliers = options.truncation;
  return graph;
}

void Announce(StageListener* listener, Stage stage) {
  if (listener != nullptr) listener->OnStageBegin(stage);
}

template <typename Matrix>
double PositionSigma(const Matrix& covariance) {
  return std::sqrt(covariance.template topLeftCorner<2, 2>().trace());
}

}  // namespace

template <int Dim>
Pipeline<Dim>::Pipeline(std::shared_ptr<const RadarMap> map, Rig rig,
                        const std::optional<InitialPose>& initial_pose,
                        const LocalizerOptions& options,
                        std::shared_ptr<const RegistrationMethod<Dim>> method)
    : rig_(std::move(rig)),
      options_(options),
      ego_motion_(options.ego_motion),
      submap_(options.scans_per_submap),
      schedule_(options.schedule, options.scans_per_submap * static_cast<int>(rig_.radars.size())),
      matcher_(map, method, options.matcher),
      global_localizer_(std::move(map), std::move(method), options.matcher.local_map_radius_m,
                        options.global),
      pose_prior_(options.prior),
      hypotheses_(GraphOptions(options)),
      tracking_(options.tracking),
      noise_scales_(options.noise_scales),
      beta_monitor_(rig_, options.beta_monitor) {
  if (initial_pose) Start(*initial_pose);
}

template <int Dim>
void Pipeline<Dim>::Start(const InitialPose& initial_pose) {
  if (!pose_prior_.IsPrediction(initial_pose.covariance)) {
    pose_prior_.Set({.pose = initial_pose.T_map_vehicle, .covariance = initial_pose.covariance});
    return;
  }
  RegistrationWorkspace<Dim> workspace;
  matcher_.MoveTo(initial_pose.T_map_vehicle.translation_m, workspace);
  hypotheses_.Reset(FromSpace<Dim>(matcher_.T_map_local().Inverse() * initial_pose.T_map_vehicle,
                                   initial_pose.covariance));
  tracking_.OnPrior();
}

// One scan, top to bottom: the paper's Fig. 2.
template <int Dim>
absl::StatusOr<Localization> Pipeline<Dim>::Localize(const Scan& scan,
                                                     LocalizerWorkspace& lent_workspace,
                                                     StageListener* listener) {
  if (absl::Status status = Check(scan); !status.ok()) return status;
  stamp_order_.Accept(scan);
  const RadarModel& radar = *rig_.Find(scan.radar_id);
  Workspace<Dim>& workspace = lent_workspace.Of<Dim>();

  Announce(listener, Stage::kCompensation);  // eq 6, 9-11
  const EgoVelocity& ego_velocity = ego_motion_.Advance(scan, radar, workspace.ego_velocity);
  StaticPoints(scan, radar, ego_velocity, PointOptions(options_), workspace.static_points);

  Announce(listener, Stage::kSubmap);  // eq 7-8
  Move(ego_motion_.since_previous());
  AddToSubmap(scan, radar, workspace.static_points, ego_motion_.since_previous());

  const bool is_steady = tracking_.mode() == TrackingMode::kTracking && quality_.edge_valid;
  if (schedule_.IsDue(is_steady)) {
    submap_.Join(options_.uncertainty, static_cast<std::size_t>(options_.max_submap_points),
                 workspace.submap);
    quality_ = {};

    Announce(listener, Stage::kRegistration);  // eq 12-14
    Predict(scan.stamp, workspace.registration);
    const std::optional<Registration<Dim>> registration = Register(scan.stamp, workspace);

    Announce(listener, Stage::kPoseGraph);  // eq 15-19
    if (registration) UpdateObservability(*registration, scan.stamp, workspace);
    const bool was_tracking = tracking_.mode() == TrackingMode::kTracking;
    const RegistrationOutcome outcome = UpdatePose(registration, ego_velocity, workspace);
    if (!was_tracking) {
      ego_motion_.OnJump();
      noise_scales_.OnJump();
    } else if (outcome == RegistrationOutcome::kAccepted) {
      UpdateEstimators(*registration, ego_velocity, scan.stamp, workspace);
    }
    tracking_.OnRegistration(scan.stamp, outcome);
    HandleLoss(scan.stamp);
    schedule_.OnRegistration();
  }
  return Answer(scan);
}

template <int Dim>
absl::Status Pipeline<Dim>::Check(const Scan& scan) const {
  if (absl::Status status = Validate(scan); !status.ok()) return status;
  if (rig_.Find(scan.radar_id) == nullptr) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "radar_id '%s' is not one of the rig's %d radars", scan.radar_id, rig_.radars.size()));
  }
  return stamp_order_.Check(scan);
}

template <int Dim>
void Pipeline<Dim>::Move(const Motion& motion) {
  noise_scales_.OnMotion(ToEstimate<Dim>(motion));
  since_state_ = Compose(since_state_, motion);
  pose_prior_.OnMotion(motion);
  global_localizer_.OnMotion(motion);
}

template <int Dim>
void Pipeline<Dim>::AddToSubmap(const Scan& scan, const RadarModel& radar,
                                const std::vector<RadarPoint>& points, const Motion& motion) {
  if (PositionSigma(motion.covariance) > options_.max_gap_sigma_m ||
      std::sqrt(motion.covariance(5, 5)) > options_.max_gap_sigma_rad) {
    submap_.Clear();
    noise_scales_.OnJump();
    gap_since_state_ = true;
  }
  submap_.Push(scan.stamp, static_cast<int>(&radar - rig_.radars.data()), points, motion);
  schedule_.OnScan(scan.stamp, submap_.scan_count());
}

// A new state, where odometry puts it, and the local map around it.
template <int Dim>
void Pipeline<Dim>::Predict(Stamp stamp, RegistrationWorkspace<Dim>& workspace) {
  if (!tracking_.has_pose()) return;
  hypotheses_.AddState(OdometryEdge(), OdometryNoise());
  since_state_ = {};
  gap_since_state_ = false;
  const PoseEstimate<3> predicted = ToSpace<Dim>(hypotheses_.Newest(), options_.unobserved);
  tracking_.OnPrediction(stamp, PositionSigma(predicted.covariance));
  EnterLocalFrame((matcher_.T_map_local() * predicted.pose).translation_m, workspace);
}

// The local map follows the vehicle; what the pose graph knows is re-expressed in its new frame.
template <int Dim>
void Pipeline<Dim>::EnterLocalFrame(const Eigen::Vector3d& p_map,
                                    RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_old = matcher_.T_map_local();
  if (!matcher_.MoveTo(p_map, workspace)) return;
  const Pose3 T_new_old = matcher_.T_map_local().Inverse() * T_map_old;
  hypotheses_.ChangeFrame(FromSpace<Dim>(T_new_old, Matrix6d::Zero()).pose);
}

template <int Dim>
std::optional<Registration<Dim>> Pipeline<Dim>::Register(Stamp stamp, Workspace<Dim>& workspace) {
  const std::span<const GaussianPoint<Dim>> live = workspace.submap.points;
  std::optional<Registration<Dim>> registration =
      tracking_.has_pose()
          ? matcher_.Match(live, hypotheses_.Newest(), observability_,
                           static_cast<std::uint64_t>(stamp.time_since_epoch().count()),
                           workspace.registration)
          : LocalizeGlobally(live, stamp, workspace.registration);
  if (!registration) return std::nullopt;
  quality_.inlier_count = registration->inlier_count;
  quality_.overlap = registration->overlap;
  quality_.residual_scale = registration->residual_scale;
  return registration;
}

template <int Dim>
std::optional<Registration<Dim>> Pipeline<Dim>::LocalizeGlobally(
    std::span<const GaussianPoint<Dim>> live, Stamp stamp, RegistrationWorkspace<Dim>& workspace) {
  const bool sees_enough =
      submap_.span() >= options_.global.min_view_span &&
      live.size() >= static_cast<std::size_t>(options_.global.gate.min_inlier_count);
  if (sees_enough && global_localizer_.WantsView(stamp)) {
    global_localizer_.AddView(stamp, live, pose_prior_.Region());
  }
  const std::optional<Pose3> T_map_vehicle = global_localizer_.Continue(workspace);
  if (!T_map_vehicle) return std::nullopt;
  global_localizer_.Clear();
  return matcher_.MatchFound(live, *T_map_vehicle, options_.global.gate, workspace);
}

// Streets change slowly: once for each sub-map is enough.
template <int Dim>
void Pipeline<Dim>::UpdateObservability(const Registration<Dim>& registration, Stamp stamp,
                                        Workspace<Dim>& workspace) {
  if (observability_stamp_ && stamp - *observability_stamp_ <= submap_.span()) return;
  observability_stamp_ = stamp;
  observability_ = matcher_.Observed(workspace.submap.points, registration, workspace.registration);
}

// Where there is no pose, the registration starts a pose graph; else it is a factor of it.
template <int Dim>
RegistrationOutcome Pipeline<Dim>::UpdatePose(const std::optional<Registration<Dim>>& registration,
                                              const EgoVelocity& ego_velocity,
                                              Workspace<Dim>& workspace) {
  if (!registration) return RegistrationOutcome::kNoMatch;
  const std::chrono::nanoseconds span = submap_.span();
  factor_count_ = tracking_.has_pose() ? factor_count_ + 1 : 1;
  TangentMatrix<Dim> degeneracy = TangentMatrix<Dim>::Zero();
  degeneracy.template topLeftCorner<2, 2>() = observability_.DegeneracyCovariance();
  const AbsolutePoseFactor<Dim> factor = RegistrationFactor<Dim>(
      *registration, degeneracy,
      noise_scales_.RegistrationCovariance(ResidualScaledCovariance<Dim>(*registration)),
      CalibrationCovariance<Dim>(workspace.submap, rig_, ego_velocity),
      {.interval = schedule_.SinceRegistration().value_or(span),
       .submap_span = span,
       .speed_mps = ego_velocity.linear_mps.norm(),
       .count = factor_count_},
      options_.factor);
  EdgeTest test{.valid = true};
  if (tracking_.has_pose()) {
    test = hypotheses_.AddAbsolutePose(factor);
  } else {
    hypotheses_.Reset({.pose = factor.pose, .covariance = factor.covariance}, factor.systematic);
    since_state_ = {};
    tracking_.OnPlaceFound();
  }
  quality_.edge_distance = test.distance;
  quality_.edge_valid = test.valid;
  return test.valid ? RegistrationOutcome::kAccepted : RegistrationOutcome::kOutlier;
}

// What an accepted registration tells of beta, of the odometry and of the noise of both. It is one
// of a vehicle that was tracking before it.
template <int Dim>
void Pipeline<Dim>::UpdateEstimators(const Registration<Dim>& registration,
                                     const EgoVelocity& ego_velocity, Stamp stamp,
                                     Workspace<Dim>& workspace) {
  if (beta_monitor_.IsDue(stamp, submap_.span())) {
    beta_monitor_.OnRegistration(
        stamp, workspace.submap,
        matcher_.Correspondences(workspace.submap.points, registration.T_local_vehicle,
                                 workspace.registration),
        registration.T_local_vehicle, ego_velocity);
  }
  // Registrations that share scans share their errors.
  if (estimators_stamp_ && stamp - *estimators_stamp_ <= submap_.span()) return;
  estimators_stamp_ = stamp;
  const TangentMatrix<Dim> own = ResidualScaledCovariance<Dim>(registration);
  const PoseEstimate<3> in_space =
      ToSpace<Dim>({.pose = registration.T_local_vehicle,
                    .covariance = noise_scales_.RegistrationCovariance(own)},
                   options_.unobserved);
  const Pose3& T_map_local = matcher_.T_map_local();
  ego_motion_.OnPose(T_map_local * in_space.pose, FlattenCovariance(in_space.covariance));
  const Pose<Dim> T_map_vehicle =
      FromSpace<Dim>(T_map_local, Matrix6d::Zero()).pose * registration.T_local_vehicle;
  noise_scales_.OnRegistration({.pose = T_map_vehicle, .covariance = own});
}

// A pose that is given up becomes a prior, but for a place that was refused.
template <int Dim>
void Pipeline<Dim>::HandleLoss(Stamp stamp) {
  if (tracking_.mode() == TrackingMode::kTracking) pose_prior_.Forget();
  if (!tracking_.has_pose()) return;
  PoseEstimate<3> now = ToSpace<Dim>(Now(), options_.unobserved);
  const Loss loss = tracking_.GiveUpIfLost(stamp, PositionSigma(now.covariance));
  if (loss == Loss::kNone) return;
  if (loss == Loss::kContradicted) {
    InflateCovariance(now.covariance);
    // What was learned on the way to a wrong pose is wrong.
    ego_motion_.Forget();
    noise_scales_ = NoiseScaleEstimator<Dim>(options_.noise_scales);
  }
  if (loss != Loss::kPlaceRefused) {
    pose_prior_.Set({.pose = matcher_.T_map_local() * now.pose, .covariance = now.covariance});
  }
  hypotheses_.Clear();
}

template <int Dim>
void Pipeline<Dim>::InflateCovariance(Matrix6d& covariance) const {
  covariance.topLeftCorner<2, 2>().diagonal().array() +=
      options_.contradicted_sigma_m * options_.contradicted_sigma_m;
  covariance(5, 5) += options_.contradicted_sigma_rad * options_.contradicted_sigma_rad;
}

template <int Dim>
PoseEstimate<Dim> Pipeline<Dim>::Now() const {
  const PoseEstimate<Dim> newest = hypotheses_.Newest();
  const PoseEstimate<Dim> motion = ToEstimate<Dim>(since_state_);
  return {.pose = newest.pose * motion.pose,
          .covariance = ComposeCovariance<Dim>(newest.covariance, motion.pose, motion.covariance)};
}

template <int Dim>
TangentMatrix<Dim> Pipeline<Dim>::NoiseNow() const {
  return ComposeCovariance<Dim>(hypotheses_.NewestNoise(), ToEstimate<Dim>(since_state_).pose,
                                OdometryNoise());
}

// What is learned of odometry says nothing of what happened in a gap.
template <int Dim>
PoseEstimate<Dim> Pipeline<Dim>::OdometryEdge() const {
  PoseEstimate<Dim> edge = ToEstimate<Dim>(since_state_);
  if (!gap_since_state_) edge.covariance = noise_scales_.OdometryWeightCovariance(edge.covariance);
  return edge;
}

template <int Dim>
TangentMatrix<Dim> Pipeline<Dim>::OdometryNoise() const {
  const TangentMatrix<Dim> covariance = ToEstimate<Dim>(since_state_).covariance;
  return gap_since_state_ ? covariance : noise_scales_.OdometryCovariance(covariance);
}

template <int Dim>
Localization Pipeline<Dim>::Answer(const Scan& scan) {
  Localization answer{.stamp = scan.stamp, .quality = quality_};
  answer.quality.live_point_count = static_cast<int>(submap_.point_count());
  answer.quality.beta =
      beta_monitor_.Check(static_cast<std::size_t>(rig_.Find(scan.radar_id) - rig_.radars.data()));
  if (!tracking_.has_pose()) {
    answer.covariance = kUnknownVariance * Matrix6d::Identity();
    if (pose_prior_.now()) {
      answer.T_map_vehicle = pose_prior_.now()->pose;
      answer.covariance = pose_prior_.now()->covariance;
    }
    answer.state = tracking_.Report(PositionSigma(answer.covariance));
    return answer;
  }
  const PoseEstimate<3> now = ToSpace<Dim>(Now(), options_.unobserved);
  tracking_.OnPrediction(scan.stamp, PositionSigma(now.covariance));
  answer.T_map_vehicle = matcher_.T_map_local() * now.pose;
  answer.covariance =
      ToSpace<Dim>({.pose = {}, .covariance = NoiseNow()}, options_.unobserved).covariance;
  answer.state = tracking_.Report(PositionSigma(answer.covariance));
  for (int i = 0; i < kDofInSpace; ++i) {
    answer.observed[static_cast<std::size_t>(i)] =
        i < 2 ? observability_.Observed(i) : Dim == 3 || i == 5;
  }
  return answer;
}

template class Pipeline<2>;
template class Pipeline<3>;

}  // namespace dcloc
