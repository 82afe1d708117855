#include "core/localizer/pipeline.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "core/geometry/covariance.h"
#include "core/geometry/pose_estimate.h"
#include "core/uncertainty/calibration_covariance.h"
#include "core/uncertainty/registration_factor.h"

namespace dcloc {
namespace {

void Announce(StageListener* listener, Stage stage) {
  if (listener != nullptr) listener->OnStageBegin(stage);
}

}  // namespace

template <int Dim>
Pipeline<Dim>::Pipeline(std::shared_ptr<const RadarMap> map, Rig rig,
                        const std::optional<InitialPose>& initial_pose,
                        const LocalizerOptions& options,
                        std::shared_ptr<const RegistrationMethod<Dim>> method)
    : options_(options),
      learned_rig_(std::move(rig), options.learned_rig),
      radar_monitor_(learned_rig_.rig().radars.size(), options.radar_monitor),
      ego_motion_(options.ego_motion, options.static_points),
      submap_(options.scans_per_submap, options.submap),
      schedule_(options.schedule,
                options.scans_per_submap * static_cast<int>(learned_rig_.rig().radars.size())),
      matcher_(map, method, options.matcher),
      relocalizer_(std::move(map), std::move(method), options.matcher.local_map_radius_m,
                   options.prior, options.global),
      pose_(EffectivePoseGraph(options), options.noise_scales),
      tracking_(options.tracking),
      learner_(learned_rig_.rig(), options.beta_monitor, options.unobserved),
      scan_checker_(learned_rig_.rig().radars.size(), options.map_fit),
      way_rivals_(options.way_rivals),
      fix_monitor_(options.fixes),
      protection_level_(options.protection_level),
      reset_counter_(options.resets),
      knowledge_report_(options.knowledge_report) {
  learned_rig_.Begin(options.known);
  ego_motion_.Begin(options.known);
  if (initial_pose) Start(*initial_pose);
}

template <int Dim>
void Pipeline<Dim>::Start(const InitialPose& initial_pose) {
  relocalizer_.SetPrior(
      {.pose = initial_pose.T_map_vehicle, .covariance = initial_pose.covariance});
  if (!relocalizer_.IsPrediction(initial_pose.covariance)) return;
  RegistrationWorkspace<Dim> workspace;
  matcher_.MoveTo(initial_pose.T_map_vehicle.translation_m, workspace);
  pose_.Reset(FromSpace<Dim>(matcher_.T_map_local().Inverse() * initial_pose.T_map_vehicle,
                             initial_pose.covariance));
  tracking_.OnPrior();
  if (!options_.verify_prior) tracking_.OnVerified();
}

// One scan, top to bottom: the paper's Fig. 2.
template <int Dim>
Localization Pipeline<Dim>::LocalizeNext(const Scan& scan, const TimeBase::ScanTime& time,
                                         LocalizerWorkspace& lent_workspace,
                                         StageListener* listener) {
  const Stamp stamp = time.stamp;
  const std::size_t radar_index = learned_rig_.IndexOf(scan.radar_id);
  const RadarModel& radar = learned_rig_.rig().radars[radar_index];
  Workspace<Dim>& workspace = lent_workspace.Of<Dim>();

  Announce(listener, Stage::kCompensation);  // eq 6, 9-11
  const EgoVelocity& ego_velocity = ego_motion_.Advance(scan, stamp, radar, workspace.ego_velocity);
  const std::optional<EgoVelocity>& by_gyroscope = ego_motion_.by_gyroscope();
  if (by_gyroscope && learned_rig_.OnScan(stamp, radar_index, scan, *by_gyroscope)) {
    submap_.DropPoints(static_cast<int>(radar_index));
  }
  Compensate(scan, stamp, ego_velocity, workspace.static_points);

  Announce(listener, Stage::kSubmap);  // eq 7-8
  Motion motion = ego_motion_.since_previous();
  if (time.clock_was_set) {  // for how long the vehicle moved is not known
    motion.covariance(0, 0) +=
        std::pow(options_.clock_set_sigma_s * ego_velocity.linear_mps.norm(), 2);
  }
  Move(motion);
  CheckScanFit(stamp, radar_index, workspace);
  if (!IsTrusted(radar_index, stamp)) workspace.static_points.clear();
  AddToSubmap(stamp, radar_index, workspace.static_points, motion);

  const bool is_steady = tracking_.mode() == TrackingMode::kConfirmed &&
                         newest_outcome_ == RegistrationOutcome::kAccepted;
  if (schedule_.IsDue(is_steady)) {
    submap_.Join(options_.uncertainty, static_cast<std::size_t>(options_.max_submap_points),
                 workspace.submap);
    quality_ = {};
    newest_outcome_ = RegistrationOutcome::kNoMatch;

    Announce(listener, Stage::kRegistration);  // eq 12-14
    Predict(stamp, workspace.registration);
    const bool waits_for_points = tracking_.has_pose() && !schedule_.has_new_points();
    const std::optional<Registered> registered = Register(stamp, workspace);
    if (!registered && waits_for_points) {  // nothing was tried that could have failed
      HandleLoss(stamp);
      return Answer(scan, stamp);
    }

    Announce(listener, Stage::kPoseGraph);  // eq 15-19
    if (registered) UpdateObservability(registered->registration, stamp, workspace);
    const bool was_confirmed = tracking_.mode() == TrackingMode::kConfirmed;
    newest_outcome_ = UpdatePose(registered, ego_velocity, workspace);
    UpdateOdometry(registered, newest_outcome_);
    if (was_confirmed && newest_outcome_ == RegistrationOutcome::kAccepted) {
      learner_.OnAccepted(stamp, registered->registration, ego_velocity, submap_.span(), matcher_,
                          ego_motion_, pose_, workspace);
    }
    tracking_.OnRegistration(stamp, newest_outcome_);
    HandleLoss(stamp);
    schedule_.OnRegistration();
  }
  return Answer(scan, stamp);
}

template <int Dim>
Localization Pipeline<Dim>::LocalizeLate(const Scan& scan, Stamp stamp,
                                         LocalizerWorkspace& lent_workspace) {
  Localization answer = Answer(scan, stamp);
  const std::optional<MotionHistory::Moment> moment = ego_motion_.history().At(stamp);
  if (!moment) return answer;
  const std::size_t radar_index = learned_rig_.IndexOf(scan.radar_id);
  std::vector<RadarPoint>& points = lent_workspace.Of<Dim>().static_points;
  Compensate(scan, stamp, moment->velocity, points);
  if (IsTrusted(radar_index, stamp)) {
    const bool is_kept = submap_.Insert(stamp, static_cast<int>(radar_index), points);
    if (is_kept) schedule_.OnLateScan(points.size());
  }
  const Motion then =
      Compose({answer.T_map_vehicle, answer.covariance}, Inverse(moment->to_newest));
  if (answer.protection_level_m) {  // the way between the two is as uncertain as it makes the pose
    *answer.protection_level_m +=
        protection_level_.Of(then.covariance) - protection_level_.Of(answer.covariance);
  }
  answer.T_map_vehicle = then.T_from_to;
  answer.covariance = then.covariance;
  return answer;
}

template <int Dim>
void Pipeline<Dim>::Move(const Motion& motion) {
  pose_.OnMotion(motion);
  relocalizer_.OnMotion(motion);
  reset_counter_.OnMotion(ego_motion_.expected_motion());
  // The noise was learned with other sources in use.
  if (ego_motion_.sources_changed()) pose_.ResetNoise();
  if (HorizontalSigma(ego_motion_.doubt_since_previous()) > options_.usual_doubt_m) pose_.OnGap();
}

template <int Dim>
void Pipeline<Dim>::Compensate(const Scan& scan, Stamp stamp, const EgoVelocity& ego_velocity,
                               std::vector<RadarPoint>& points) {
  const std::size_t radar_index = learned_rig_.IndexOf(scan.radar_id);
  StaticPoints(scan, learned_rig_.rig().radars[radar_index], ego_velocity,
               EffectiveStaticPoints(options_), points);
  radar_monitor_.OnScan(stamp, radar_index, scan.size(), points.size());
}

template <int Dim>
void Pipeline<Dim>::AddToSubmap(Stamp stamp, std::size_t radar_index,
                                const std::vector<RadarPoint>& points, const Motion& motion) {
  // Doubt in the sources is left out. If those in use are wrong, they misplace new scans as they
  // did the old ones, and dropping these mends nothing.
  const Matrix6d gap = motion.covariance - ego_motion_.doubt_since_previous();
  if (HorizontalSigma(gap) > options_.max_gap_sigma_m ||
      std::sqrt(gap(5, 5)) > options_.max_gap_sigma_rad) {
    submap_.Clear();
    pose_.OnGap();
  }
  submap_.Push(stamp, static_cast<int>(radar_index), points, motion);
  schedule_.OnScan(stamp, submap_.scan_count(), points.size());
}

template <int Dim>
void Pipeline<Dim>::CheckScanFit(Stamp stamp, std::size_t radar_index, Workspace<Dim>& workspace) {
  if (!tracking_.has_pose()) return;
  const bool was_confirmed = tracking_.mode() == TrackingMode::kConfirmed;
  const ScanFit fit = scan_checker_.Test(stamp, radar_index, workspace.static_points, pose_.Now(),
                                         matcher_, workspace);
  radar_monitor_.OnFit(radar_index, scan_checker_.last_fit());
  if (!IsTrusted(radar_index, stamp)) return;
  // The places that are compared are relative to the pose: where that is lost, both are wrong.
  if (!tracking_.is_lost()) CompareSourcesByMapFit(workspace);
  tracking_.OnScanFit(fit);
  if (scan_checker_.HasDeclined()) tracking_.OnRivalFits();
  CompareWayRivals(workspace);
  if (tracking_.mode() == TrackingMode::kConfirmed) {
    scan_checker_.OnConfirmed();
    if (newest_outcome_ == RegistrationOutcome::kAccepted && fit != ScanFit::kContradicts) {
      scan_checker_.Learn();
    }
  } else if (was_confirmed) {
    relocalizer_.SetPrior(NowInMap());
  }
}

// A new state, where odometry puts it, and the local map around it.
template <int Dim>
void Pipeline<Dim>::Predict(Stamp stamp, RegistrationWorkspace<Dim>& workspace) {
  if (!tracking_.has_pose()) return;
  pose_.AddState();
  const PoseEstimate<3> predicted = ToSpace<Dim>(pose_.Newest(), options_.unobserved);
  tracking_.OnPrediction(stamp, HorizontalSigma(predicted.covariance));
  EnterLocalFrame((matcher_.T_map_local() * predicted.pose).translation_m, workspace);
}

// The local map follows the vehicle; what the pose graph knows is re-expressed in its new frame.
template <int Dim>
void Pipeline<Dim>::EnterLocalFrame(const Eigen::Vector3d& p_map,
                                    RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_old = matcher_.T_map_local();
  if (!matcher_.MoveTo(p_map, workspace)) return;
  const Pose3 T_new_old = matcher_.T_map_local().Inverse() * T_map_old;
  pose_.ChangeFrame(FromSpace<Dim>(T_new_old, Matrix6d::Zero()).pose);
}

template <int Dim>
std::optional<typename Pipeline<Dim>::Registered> Pipeline<Dim>::Register(
    Stamp stamp, Workspace<Dim>& workspace) {
  const std::span<const GaussianPoint<Dim>> live = workspace.submap.points;
  std::optional<Registration<Dim>> registration;
  const std::optional<Place> place = SearchPlace(live, stamp, workspace.registration);
  const bool is_new_place = place && !place->is_expected;
  if (is_new_place) {
    EnterLocalFrame(place->T_map_vehicle.translation_m, workspace.registration);
    registration = matcher_.MatchFound(live, place->T_map_vehicle, options_.global.gate,
                                       workspace.registration);
  } else if (tracking_.has_pose() && schedule_.has_new_points()) {
    registration = matcher_.Match(live, pose_.Newest(), observability_,
                                  static_cast<std::uint64_t>(stamp.time_since_epoch().count()),
                                  workspace.registration);
  }
  if (!registration) return std::nullopt;
  quality_.inlier_count = registration->inlier_count;
  quality_.overlap = registration->overlap;
  quality_.residual_scale = registration->residual_scale;
  return Registered{.registration = *registration, .is_new_place = is_new_place};
}

// Where there is no pose, or one that may be wrong.
template <int Dim>
std::optional<typename Pipeline<Dim>::Place> Pipeline<Dim>::SearchPlace(
    std::span<const GaussianPoint<Dim>> live, Stamp stamp, RegistrationWorkspace<Dim>& workspace) {
  using Basis = typename GlobalLocalizer<Dim>::Basis;
  std::optional<typename Relocalizer<Dim>::ExpectedPlace> expected;
  if (tracking_.has_pose()) {
    if (!tracking_.needs_verification()) return std::nullopt;
    if (scan_checker_.IsTooSoonToJudge(stamp, submap_.span())) return std::nullopt;
    expected = {.T_map_vehicle = NowInMap().pose,
                .basis = tracking_.is_trusted_prior() ? Basis::kPrior : Basis::kDoubted};
    if (!relocalizer_.prior()) relocalizer_.SetPrior(NowInMap());
  }
  std::optional<Place> place =
      relocalizer_.Search(stamp, live, submap_.span(), expected, workspace);
  if (place && place->is_expected) {
    tracking_.OnVerified();
    scan_checker_.Reset();
    fix_monitor_.OnRefuted();
  }
  return place;
}

template <int Dim>
void Pipeline<Dim>::UpdateObservability(const Registration<Dim>& registration, Stamp stamp,
                                        Workspace<Dim>& workspace) {
  const bool is_decisive =
      ego_motion_.doubted_way_m() > options_.ego_motion.sources.min_rival_way_m;
  if (!observability_schedule_.IsDue(stamp, submap_.span(), is_decisive)) return;
  observability_ = matcher_.Observed(workspace.submap.points, registration, workspace.registration);
  tracking_.OnObservability(stamp, observability_.ObservesAll());
}

// A registration at a new place starts a pose graph; any other is a factor of the one there is.
template <int Dim>
RegistrationOutcome Pipeline<Dim>::UpdatePose(const std::optional<Registered>& registered,
                                              const EgoVelocity& ego_velocity,
                                              Workspace<Dim>& workspace) {
  if (!registered) return RegistrationOutcome::kNoMatch;
  const Registration<Dim>& registration = registered->registration;
  const std::chrono::nanoseconds span = submap_.span();
  factor_count_ = registered->is_new_place ? 1 : factor_count_ + 1;
  TangentMatrix<Dim> degeneracy = TangentMatrix<Dim>::Zero();
  degeneracy.template topLeftCorner<2, 2>() =
      observability_.DegeneracyCovariance(options_.matcher.observability.degenerate_sigma_m);
  const AbsolutePoseFactor<Dim> factor = RegistrationFactor<Dim>(
      registration, degeneracy,
      pose_.noise_scales().RegistrationCovariance(ResidualScaledCovariance<Dim>(registration)),
      CalibrationCovariance<Dim>(workspace.submap, learned_rig_.rig(), ego_velocity),
      {.interval = schedule_.SinceRegistration().value_or(span),
       .submap_span = span,
       .speed_mps = ego_velocity.linear_mps.norm(),
       .count = factor_count_},
      options_.factor);
  EdgeTest test{.valid = true};
  if (!registered->is_new_place) {
    test = pose_.AddAbsolutePose(factor);
    const Tangent<Dim> apart = Log(pose_.Newest().pose.Inverse() * factor.pose);
    protection_level_.OnInnovation(test.squared_distance / Pose<Dim>::kDof,
                                   apart.template head<2>());
  } else {
    scan_checker_.Reset();
    way_rivals_.Reset();
    radar_monitor_.ResetFits();
    ego_motion_.OnPlaceChanged();
    pose_.Reset({.pose = factor.pose, .covariance = factor.covariance}, factor.systematic);
    tracking_.OnPlaceFound();
  }
  quality_.edge_distance = test.squared_distance;
  quality_.edge_valid = test.valid;
  if (test.valid && registration.overlap >= options_.azimuth_sign_overlap) {
    learned_rig_.OnRegistered();
  }
  return test.valid ? RegistrationOutcome::kAccepted : RegistrationOutcome::kOutlier;
}

// Registrations measure the motion without the sources of odometry, which are held against them.
// While the pose is not confirmed, two in a row may be at two places, and teach nothing.
template <int Dim>
void Pipeline<Dim>::UpdateOdometry(const std::optional<Registered>& registered,
                                   RegistrationOutcome outcome) {
  if (tracking_.mode() != TrackingMode::kConfirmed) {
    ego_motion_.OnBreak();
    pose_.OnBreak();
  }
  if (!registered) return;
  const PoseEstimate<3> T_local_vehicle =
      ToSpace<Dim>({.pose = registered->registration.T_local_vehicle}, options_.unobserved);
  ego_motion_.OnRegistration(matcher_.T_map_local() * T_local_vehicle.pose,
                             {.is_accepted = outcome == RegistrationOutcome::kAccepted,
                              .observes_way = observability_.Observed(0)});
}

// A pose that is given up becomes the prior of the search, unless it is a place that was refused.
template <int Dim>
void Pipeline<Dim>::HandleLoss(Stamp stamp) {
  if (tracking_.mode() == TrackingMode::kConfirmed) relocalizer_.OnFound();
  if (!tracking_.has_pose()) return;
  PoseEstimate<3> now = ToSpace<Dim>(pose_.Now(), options_.unobserved);
  const Loss loss = tracking_.GiveUpIfLost(stamp, HorizontalSigma(now.covariance));
  if (loss == Loss::kNone) return;
  if (loss == Loss::kContradicted) {
    now.covariance.diagonal() += ContradictedVariances(options_);
    // Scale, bias and noise were learned from poses at a wrong place.
    ego_motion_.ResetErrors();
    pose_.ResetNoise();
  }
  if (loss != Loss::kPlaceRefused) {
    now.pose = matcher_.T_map_local() * now.pose;
    relocalizer_.SetPrior(now);
  }
  pose_.Clear();
}

template <int Dim>
PoseEstimate<3> Pipeline<Dim>::NowInMap() const {
  const PoseEstimate<3> now = ToSpace<Dim>(pose_.Now(), options_.unobserved);
  return {.pose = matcher_.T_map_local() * now.pose, .covariance = now.covariance};
}

template class Pipeline<2>;
template class Pipeline<3>;

}  // namespace dcloc
