#include "core/localizer/pipeline.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/geometry/covariance.h"
#include "core/localizer/planar_or_spatial.h"
#include "core/localizer/workspace.h"
#include "core/uncertainty/calibration_covariance.h"
#include "core/uncertainty/registration_factor.h"

namespace dcloc {
namespace {

constexpr int kDofInSpace = 6;

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

double Nanoseconds(Stamp stamp) { return static_cast<double>(stamp.time_since_epoch().count()); }

}  // namespace

template <int Dim>
Pipeline<Dim>::Pipeline(std::shared_ptr<const RadarMap> map, Rig rig,
                        const std::optional<InitialPose>& initial_pose,
                        const LocalizerOptions& options)
    : rig_(std::move(rig)),
      options_(options),
      ego_motion_(options),
      window_(options.scans_per_submap),
      matcher_(map, options),
      global_localizer_(std::move(map), options),
      graph_(GraphOptions(options)),
      state_(options.state),
      pose_prior_(options.match),
      beta_monitor_(rig_) {
  if (initial_pose) Start(*initial_pose);
}

// One scan, top to bottom: the paper's Fig. 2.
template <int Dim>
absl::StatusOr<Localization> Pipeline<Dim>::Localize(const Scan& scan, StageListener* listener) {
  if (absl::Status status = Validate(scan); !status.ok()) return status;
  if (absl::Status status = CheckOrder(scan); !status.ok()) return status;
  const RadarModel& radar = *rig_.Find(scan.radar_id);
  last_stamp_ = last_stamp_of_radar_[scan.radar_id] = scan.stamp;

  Announce(listener, Stage::kCompensation);
  Workspace<Dim>& workspace = Workspace<Dim>::OfThisThread();
  const EgoVelocity& ego_velocity = ego_motion_.Advance(scan, radar, workspace.ego_velocity);
  StaticPoints(scan, radar, ego_velocity, PointOptions(options_), workspace.static_points);

  Announce(listener, Stage::kSubmap);
  const Motion& motion = ego_motion_.since_previous();
  noise_scales_.OnMotion(ToEstimate<Dim>(motion));
  since_state_ = Compose(since_state_, motion);
  pose_prior_.OnMotion(motion);
  global_localizer_.OnMotion(motion);
  PushScan(scan, radar, motion);
  ++scans_since_registration_;

  if (RegistrationIsDue(scan.stamp)) {
    window_.Join(options_.uncertainty, static_cast<std::size_t>(options_.match.max_live_points),
                 workspace.submap);
    quality_ = {};

    Announce(listener, Stage::kRegistration);
    const std::optional<Registration<Dim>> registration =
        Register(workspace.submap.points, scan.stamp);

    Announce(listener, Stage::kPoseGraph);
    if (registration) {
      UpdateObservability(*registration, scan.stamp);
      const EdgeTest test = UpdateGraph(*registration, ego_velocity, scan.stamp);
      quality_.edge_distance = test.distance;
      quality_.edge_valid = test.valid;
    }
    Learn(registration, ego_velocity, scan.stamp);
    state_.OnRegistration(scan.stamp, !registration         ? RegistrationOutcome::kNone
                                      : quality_.edge_valid ? RegistrationOutcome::kAccepted
                                                            : RegistrationOutcome::kOutlier);
    HandleLoss(scan.stamp);
    last_registration_ = scan.stamp;
    scans_since_registration_ = 0;
  }
  return Answer(scan);
}

template <int Dim>
absl::Status Pipeline<Dim>::CheckOrder(const Scan& scan) const {
  if (rig_.Find(scan.radar_id) == nullptr) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "radar_id '%s' is not one of the rig's %d radars", scan.radar_id, rig_.radars.size()));
  }
  const auto of_radar = last_stamp_of_radar_.find(scan.radar_id);
  if (of_radar != last_stamp_of_radar_.end() && scan.stamp <= of_radar->second) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "stamp is %.0f ns; radar '%s' was at %.0f ns already, and its stamps must rise",
        Nanoseconds(scan.stamp), scan.radar_id, Nanoseconds(of_radar->second)));
  }
  if (last_stamp_ && scan.stamp < *last_stamp_) {
    return absl::InvalidArgumentError(
        absl::StrFormat("stamp is %.0f ns; it must not lie before the newest scan's %.0f ns",
                        Nanoseconds(scan.stamp), Nanoseconds(*last_stamp_)));
  }
  return absl::OkStatus();
}

template <int Dim>
void Pipeline<Dim>::Start(const InitialPose& initial_pose) {
  if (!pose_prior_.IsPrediction(initial_pose.covariance)) {
    pose_prior_.Set({.pose = initial_pose.T_map_vehicle, .covariance = initial_pose.covariance});
    return;
  }
  matcher_.MoveTo(initial_pose.T_map_vehicle.translation_m);
  graph_.Reset(FromSpace<Dim>(matcher_.T_map_local().Inverse() * initial_pose.T_map_vehicle,
                              initial_pose.covariance));
}

template <int Dim>
void Pipeline<Dim>::PushScan(const Scan& scan, const RadarModel& radar, const Motion& motion) {
  // Scans from before a silence lie where odometry puts them, all by the same error: they would
  // outvote the new ones.
  constexpr double kMaxGapSigma_m = 0.5;
  constexpr double kMaxGapSigma_rad = 0.05;
  if (std::sqrt(motion.covariance.topLeftCorner<2, 2>().trace()) > kMaxGapSigma_m ||
      std::sqrt(motion.covariance(5, 5)) > kMaxGapSigma_rad) {
    window_.Clear();
    noise_scales_.OnJump();
    was_silent_ = true;
  }
  if (window_.scan_count() == 0) window_begin_ = scan.stamp;
  window_.Push(scan.stamp, static_cast<int>(&radar - rig_.radars.data()),
               Workspace<Dim>::OfThisThread().static_points, motion);
}

template <int Dim>
bool Pipeline<Dim>::RegistrationIsDue(Stamp stamp) const {
  // A few points are easily matched wrong, and then contradict the better ones that follow.
  const auto full =
      static_cast<double>(options_.scans_per_submap) * static_cast<double>(rig_.radars.size());
  const bool mature = window_.scan_count() >= options_.state.start_share * full ||
                      stamp - window_begin_ >= options_.state.start_span;
  if (!mature) return false;
  const bool is_steady = state_.state() == LocalizationState::kTracking && quality_.edge_valid;
  if (is_steady && scans_since_registration_ < options_.tracking_scans) return false;
  return !last_registration_ || stamp - *last_registration_ >= options_.registration_interval;
}

// A place that was found and does not hold, an estimate that is lost or contradicted, and a prior
// that nothing has confirmed while it was a prediction are given up.
template <int Dim>
void Pipeline<Dim>::HandleLoss(Stamp stamp) {
  if (state_.state() == LocalizationState::kTracking) {
    pose_prior_.Forget();
  }
  if (graph_.empty()) return;
  // Searches around a prediction reach ten metres: of wider ones they would miss the truth, and
  // take another place for the only one.
  constexpr double kMaxPredictionSigma_m = 4.5;
  bool is_lost = state_.IsLostForGood(stamp);
  if (is_lost || state_.IsUnconfirmedPrior() || state_.IsContradicted()) {
    PoseEstimate<3> now = ToSpace<Dim>(Now(), options_);
    if (state_.IsContradicted()) {
      InflateCovariance(now.covariance);
      is_lost = true;
    }
    is_lost =
        is_lost || std::sqrt(now.covariance.topLeftCorner<2, 2>().trace()) > kMaxPredictionSigma_m;
    if (is_lost) {
      pose_prior_.Set({.pose = matcher_.T_map_local() * now.pose, .covariance = now.covariance});
    }
  }
  if (is_lost || state_.GlobalStartFailed()) graph_.Clear();
}

// What a contradicted estimate says of itself, and what was learned of the odometry on its way, is
// wrong.
template <int Dim>
void Pipeline<Dim>::InflateCovariance(Matrix6d& covariance) {
  constexpr double kSigma_m = 4.0;
  constexpr double kSigma_rad = 0.15;
  covariance.topLeftCorner<2, 2>().diagonal().array() += kSigma_m * kSigma_m;
  covariance(5, 5) += kSigma_rad * kSigma_rad;
  ego_motion_.Forget();
  noise_scales_ = {};
}

// The local map follows the vehicle; what the graph knows is re-expressed in its new frame.
template <int Dim>
void Pipeline<Dim>::EnterLocalFrame(const Eigen::Vector3d& p_map) {
  const Pose3 T_map_old = matcher_.T_map_local();
  if (!matcher_.MoveTo(p_map)) return;
  const Pose3 T_new_old = matcher_.T_map_local().Inverse() * T_map_old;
  graph_.ChangeFrame(FromSpace<Dim>(T_new_old, Matrix6d::Zero()).pose);
}

// While nothing is known that a registration could start from.
template <int Dim>
std::optional<Registration<Dim>> Pipeline<Dim>::Find(std::span<const GaussianPoint<Dim>> live,
                                                     Stamp stamp) {
  constexpr auto kMinSpan = std::chrono::milliseconds(400);
  const bool sees_enough =
      window_.span() >= kMinSpan &&
      live.size() >= static_cast<std::size_t>(options_.match.global_min_inlier_count);
  if (sees_enough && global_localizer_.WantsView(stamp)) {
    global_localizer_.AddView(stamp, live, pose_prior_.Region());
  }
  const std::optional<Pose3> T_map_vehicle = global_localizer_.Continue();
  if (!T_map_vehicle) return std::nullopt;
  global_localizer_.Clear();
  return matcher_.MatchFound(live, *T_map_vehicle);
}

template <int Dim>
std::optional<Registration<Dim>> Pipeline<Dim>::Register(std::span<const GaussianPoint<Dim>> live,
                                                         Stamp stamp) {
  std::optional<Registration<Dim>> registration;
  if (graph_.empty()) {
    registration = Find(live, stamp);
  } else {
    graph_.AddState(OdometryEdge(), NoiseSinceState());
    since_state_ = {};
    was_silent_ = false;
    const PoseEstimate<3> predicted = ToSpace<Dim>(graph_.Newest(), options_);
    state_.OnAnswer(stamp, std::sqrt(predicted.covariance.topLeftCorner<2, 2>().trace()));
    EnterLocalFrame((matcher_.T_map_local() * predicted.pose).translation_m);
    registration = matcher_.Match(live, graph_.Newest(), observability_,
                                  static_cast<std::uint64_t>(stamp.time_since_epoch().count()));
  }
  if (!registration) return std::nullopt;
  quality_.inlier_count = registration->inlier_count;
  quality_.overlap = registration->overlap;
  quality_.residual_scale = registration->residual_scale;
  return registration;
}

// Streets change slowly: once for each sub-map is enough.
template <int Dim>
void Pipeline<Dim>::UpdateObservability(const Registration<Dim>& registration, Stamp stamp) {
  if (observability_stamp_ && stamp - *observability_stamp_ <= window_.span()) return;
  observability_stamp_ = stamp;
  observability_ = matcher_.Observed(Workspace<Dim>::OfThisThread().submap.points, registration);
}

template <int Dim>
EdgeTest Pipeline<Dim>::UpdateGraph(const Registration<Dim>& registration,
                                    const EgoVelocity& ego_velocity, Stamp stamp) {
  const std::chrono::nanoseconds span = window_.span();
  registration_count_ = graph_.empty() ? 1 : registration_count_ + 1;
  TangentMatrix<Dim> degeneracy = TangentMatrix<Dim>::Zero();
  degeneracy.template topLeftCorner<2, 2>() = observability_.DegeneracyCovariance();
  const AbsolutePoseFactor<Dim> edge = RegistrationFactor<Dim>(
      registration, degeneracy,
      noise_scales_.RegistrationCovariance(ResidualScaledCovariance<Dim>(registration)),
      CalibrationCovariance<Dim>(Workspace<Dim>::OfThisThread().submap, rig_, ego_velocity),
      {.interval = last_registration_ ? stamp - *last_registration_ : span,
       .submap_span = span,
       .speed_mps = ego_velocity.linear_mps.norm(),
       .count = registration_count_},
      options_.match);
  if (!graph_.empty()) return graph_.AddAbsolutePose(edge);
  graph_.Reset({.pose = edge.pose, .covariance = edge.covariance}, edge.systematic);
  since_state_ = {};
  state_.StartFromGlobalSearch();
  return {.valid = true};
}

// What the believed poses tell of the vehicle's odometry.
template <int Dim>
void Pipeline<Dim>::Learn(const std::optional<Registration<Dim>>& registration,
                          const EgoVelocity& ego_velocity, Stamp stamp) {
  if (state_.state() != LocalizationState::kTracking) {
    ego_motion_.OnJump();
    noise_scales_.OnJump();
    return;
  }
  if (!registration || !quality_.edge_valid) return;
  if (beta_monitor_.IsDue(stamp, window_.span())) {
    beta_monitor_.OnRegistration(stamp, Workspace<Dim>::OfThisThread().submap,
                                 matcher_.Matches(registration->T_local_vehicle),
                                 registration->T_local_vehicle, ego_velocity);
  }
  // Registrations that share scans share their errors.
  if (last_learned_ && stamp - *last_learned_ <= window_.span()) return;
  last_learned_ = stamp;
  const PoseEstimate<Dim> registered{.pose = registration->T_local_vehicle,
                                     .covariance = noise_scales_.RegistrationCovariance(
                                         ResidualScaledCovariance<Dim>(*registration))};
  const PoseEstimate<3> in_space = ToSpace<Dim>(registered, options_);
  const Pose3& T_map_local = matcher_.T_map_local();
  ego_motion_.OnPose(T_map_local * in_space.pose, FlattenCovariance(in_space.covariance));
  const Pose<Dim> T_map_registered =
      FromSpace<Dim>(T_map_local, Matrix6d::Zero()).pose * registered.pose;
  noise_scales_.OnRegistration(
      {.pose = T_map_registered, .covariance = ResidualScaledCovariance<Dim>(*registration)});
}

template <int Dim>
PoseEstimate<Dim> Pipeline<Dim>::Now() const {
  const PoseEstimate<Dim> newest = graph_.Newest();
  const PoseEstimate<Dim> motion = ToEstimate<Dim>(since_state_);
  return {.pose = newest.pose * motion.pose,
          .covariance = ComposeCovariance<Dim>(newest.covariance, motion.pose, motion.covariance)};
}

// What is told: the estimate weighs cautiously, but what it varies by is known.
template <int Dim>
TangentMatrix<Dim> Pipeline<Dim>::Uncertainty() const {
  return ComposeCovariance<Dim>(graph_.NewestNoise(), ToEstimate<Dim>(since_state_).pose,
                                NoiseSinceState());
}

// What is learned of odometry says nothing of what happened in a silence.
template <int Dim>
PoseEstimate<Dim> Pipeline<Dim>::OdometryEdge() const {
  PoseEstimate<Dim> edge = ToEstimate<Dim>(since_state_);
  if (!was_silent_) edge.covariance = noise_scales_.OdometryWeightCovariance(edge.covariance);
  return edge;
}

template <int Dim>
TangentMatrix<Dim> Pipeline<Dim>::NoiseSinceState() const {
  const TangentMatrix<Dim> covariance = ToEstimate<Dim>(since_state_).covariance;
  return was_silent_ ? covariance : noise_scales_.OdometryCovariance(covariance);
}

template <int Dim>
Localization Pipeline<Dim>::Answer(const Scan& scan) {
  Localization answer{.stamp = scan.stamp, .quality = quality_};
  answer.quality.live_point_count = static_cast<int>(window_.point_count());
  answer.quality.beta =
      beta_monitor_.Check(static_cast<std::size_t>(rig_.Find(scan.radar_id) - rig_.radars.data()));
  if (graph_.empty()) {
    constexpr double kUnknown = 1e8;
    answer.covariance = kUnknown * Matrix6d::Identity();
    if (pose_prior_.now()) {
      answer.T_map_vehicle = pose_prior_.now()->pose;
      answer.covariance = pose_prior_.now()->covariance;
    }
    answer.state = state_.state();
    return answer;
  }
  const PoseEstimate<3> now = ToSpace<Dim>(Now(), options_);
  answer.T_map_vehicle = matcher_.T_map_local() * now.pose;
  answer.covariance = ToSpace<Dim>({.pose = {}, .covariance = Uncertainty()}, options_).covariance;
  state_.OnAnswer(scan.stamp, std::sqrt(now.covariance.topLeftCorner<2, 2>().trace()));
  answer.state = state_.state();
  // However well all agrees across, who does not know where along a tunnel it is does not track.
  const double sigma_m = std::sqrt(answer.covariance.topLeftCorner<2, 2>().trace());
  if (answer.state == LocalizationState::kTracking && sigma_m > options_.state.tracking_sigma_m) {
    answer.state = LocalizationState::kDeadReckoning;
  }
  for (int i = 0; i < kDofInSpace; ++i) {
    answer.observed[static_cast<std::size_t>(i)] =
        i < 2 ? observability_.Observed(i) : Dim == 3 || i == 5;
  }
  return answer;
}

template class Pipeline<2>;
template class Pipeline<3>;

}  // namespace dcloc
