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
      radars_(std::move(rig), options, map->info()),
      ego_motion_(options.ego_motion, options.static_points),
      live_{.submap = SubmapWindow(options.scans_per_submap, options.submap),
            .schedule = {options.schedule,
                         options.scans_per_submap *
                             static_cast<int>(radars_.learned.rig().radars.size())}},
      map_{.matcher = {map, method, options.matcher}},
      relocalizer_(std::move(map), std::move(method), options.matcher.local_map_radius_m,
                   options.prior, options.global),
      tracking_(options.tracking),
      pose_(EffectivePoseGraph(options), options.noise_scales),
      learner_(radars_.learned.rig(), options.beta_monitor, options.unobserved),
      rivals_(options.along_track_rivals),
      place_evidence_(options.place_evidence),
      fix_monitor_(options.fixes),
      claims_{.protection_level = ProtectionLevel(options.protection_level),
              .reset_counter = ResetCounter(options.resets),
              .knowledge_report = KnowledgeReport(options.knowledge_report)} {
  RestoreKnown(options.known);
  if (initial_pose) Start(*initial_pose);
}

template <int Dim>
void Pipeline<Dim>::Start(const InitialPose& initial_pose) {
  relocalizer_.SetPrior(
      {.pose = initial_pose.T_map_vehicle, .covariance = initial_pose.covariance});
  if (!relocalizer_.IsPrediction(initial_pose.covariance)) return;
  RegistrationWorkspace<Dim> workspace;
  map_.matcher.MoveTo(initial_pose.T_map_vehicle.translation_m, workspace);
  pose_.Reset(FromSpace<Dim>(map_.matcher.T_map_local().Inverse() * initial_pose.T_map_vehicle,
                             initial_pose.covariance));
  tracking_.OnPrior();
  rivals_.SupposeThatItStandsOut();  // a prior speaks for itself
  if (!options_.verify_prior) tracking_.OnVerified();
}

// One scan, top to bottom: the paper's Fig. 2. The order matters:
// - Mounts are learned before the scan is compensated, so that it is placed by the new one.
// - The pose moves before the scan is tested: the test is where odometry alone puts the vehicle.
// - The scan is tested before it joins the sub-map, which a radar that does not fit must not enter,
//   and before the registration, which moves the pose until scans fit.
// - Timeouts expire twice: before the registration, as what was confirmed before a silence does not
//   count after it; and after it, as answers claim what holds now.
template <int Dim>
Localization Pipeline<Dim>::LocalizeNext(const Scan& sent, const TimeBase::ScanTime& time,
                                         LocalizerWorkspace& lent_workspace,
                                         StageListener* listener) {
  const Stamp stamp = time.stamp;
  const std::size_t radar_index = radars_.learned.IndexOf(sent.radar_id);
  const RadarModel& radar = radars_.learned.rig().radars[radar_index];
  Workspace<Dim>& workspace = lent_workspace.Of<Dim>();
  const Scan& fresh = Fresh(sent, radar_index, workspace);
  LearnRangeRateOffset(fresh, stamp, radar_index);
  const Scan& scan = Corrected(fresh, workspace);

  Announce(listener, Stage::kCompensation);  // eq 6, 9-11
  const Scan& of_motion = TellingMotion(scan, workspace);
  const EgoVelocity& ego_velocity =
      ego_motion_.Advance(of_motion, stamp, radar, workspace.ego_velocity);
  LearnRig(of_motion, stamp, radar_index);
  Compensate(scan, stamp, ego_velocity, workspace);

  Announce(listener, Stage::kSubmap);  // eq 7-8
  const Motion motion = MotionSincePrevious(time.clock_was_set);
  Move(motion);
  TestScanFit(stamp, radar_index, workspace);
  if (!IsTrusted(radar_index, stamp)) workspace.static_points.clear();
  AddToSubmap(stamp, radar_index, workspace.static_points, motion);

  const bool is_steady = tracking_.mode() == TrackingMode::kConfirmed &&
                         newest_.outcome == RegistrationOutcome::kAccepted;
  if (live_.schedule.IsDue(is_steady)) RegisterSubmap(stamp, ego_velocity, workspace, listener);
  ExpireTimeouts(stamp);
  place_evidence_.OnClaim(stamp, tracking_.mode() == TrackingMode::kConfirmed, tracking_.is_lost());
  return FinishScan(scan, stamp);
}

// The second half of a scan that is followed by a registration. Here, too, the order matters:
// - What a registration observes is known before it becomes a factor, which is as wide as that.
// - Odometry is compared before the tracking state takes the outcome in: both ask whether the pose
//   was confirmed before this registration.
// - The pose is given up last, by what the registration has made of it.
template <int Dim>
void Pipeline<Dim>::RegisterSubmap(Stamp stamp, const EgoVelocity& ego_velocity,
                                   Workspace<Dim>& workspace, StageListener* listener) {
  live_.submap.Join(
      options_.per_point_covariance ? DriftCovariance::kAdded : DriftCovariance::kLeftOut,
      static_cast<std::size_t>(options_.max_submap_points), workspace.submap);
  newest_.quality = {};
  newest_.outcome = RegistrationOutcome::kNoMatch;

  Announce(listener, Stage::kRegistration);  // eq 12-14
  Predict(stamp, workspace.registration);
  const bool waits_for_points = tracking_.has_pose() && !live_.schedule.has_new_points();
  const std::optional<Registered> registered = Register(stamp, workspace);
  const bool was_tried = registered || !waits_for_points;

  if (was_tried) {
    Announce(listener, Stage::kPoseGraph);  // eq 15-19
    if (registered) UpdateObservability(registered->registration, stamp, workspace);
    const bool was_confirmed = tracking_.mode() == TrackingMode::kConfirmed;
    newest_.outcome = UpdatePose(stamp, registered, ego_velocity, workspace);
    UpdateOdometry(registered, newest_.outcome);
    if (was_confirmed && newest_.outcome == RegistrationOutcome::kAccepted) {
      if (radars_.range_rate_errors.OnRegistered(stamp)) ego_motion_.OnRangeRatesCorrected();
      radars_.azimuth_signs.OnConfirmed();
      relocalizer_.OnRegistered(registered->registration.score);
      learner_.OnAccepted(
          stamp, registered->registration, ego_velocity, live_.submap.span(),
          map_.observability.BluntCovariance(options_.matcher.observability.blunt_sigma_m),
          map_.matcher, ego_motion_, pose_, workspace);
    } else if (registered && registered->origin == PlaceOrigin::kExpected &&
               newest_.outcome == RegistrationOutcome::kAccepted) {
      learner_.OnDoubted(stamp, registered->registration, live_.submap.span(), map_.matcher,
                         ego_motion_, pose_);
    }
    if (newest_.outcome == RegistrationOutcome::kAccepted) {
      RegisterAlongTrackRivals(registered->registration.score, workspace);
    }
    tracking_.OnRegistration(stamp, newest_.outcome);
  }
  if (tracking_.mode() == TrackingMode::kConfirmed) {
    relocalizer_.OnFound();
    radars_.range_trial.reset();
  }
  GiveUpFailedPose(stamp);
  if (was_tried) live_.schedule.OnRegistration();
}

template <int Dim>
Localization Pipeline<Dim>::LocalizeLate(const Scan& scan, Stamp stamp,
                                         LocalizerWorkspace& lent_workspace) {
  Localization answer = FinishScan(scan, stamp);
  const std::optional<MotionHistory::Moment> moment = ego_motion_.history().At(stamp);
  if (!moment) return answer;
  const std::size_t radar_index = radars_.learned.IndexOf(scan.radar_id);
  Workspace<Dim>& workspace = lent_workspace.Of<Dim>();
  Compensate(Corrected(Fresh(scan, radar_index, workspace), workspace), stamp, moment->velocity,
             workspace);
  TestLateScanFit(stamp, radar_index, *moment, workspace);
  const std::vector<RadarPoint>& points = workspace.static_points;
  if (IsTrusted(radar_index, stamp)) {
    const bool is_kept = live_.submap.Insert(stamp, static_cast<int>(radar_index), points);
    if (is_kept) live_.schedule.OnLateScan(points.size());
  }
  // The state is what is claimed of the newest pose; its history makes no other claim of it.
  const Motion then =
      Compose({answer.T_map_vehicle, answer.covariance}, Inverse(moment->to_newest));
  if (answer.protection_level_m) {  // the motion back is as uncertain as it makes the pose
    *answer.protection_level_m += claims_.protection_level.Of(then.covariance) -
                                  claims_.protection_level.Of(answer.covariance);
  }
  answer.T_map_vehicle = then.T_from_to;
  answer.covariance = then.covariance;
  return answer;
}

// Points that another mount or another time offset has placed leave the sub-map.
template <int Dim>
void Pipeline<Dim>::LearnRig(const Scan& scan, Stamp stamp, std::size_t radar_index) {
  const std::optional<EgoVelocity>& velocity = ego_motion_.velocity_for_mounts();
  if (velocity && radars_.learned.OnScan(stamp, radar_index, scan, *velocity)) {
    live_.submap.DropPoints(static_cast<int>(radar_index));
    ego_motion_.OnMountCorrected(scan.radar_id);
  }
  radars_.restamped_s =
      radars_.learned.LearnStamps(stamp, radar_index, scan, ego_motion_.sources().AllSound());
  if (radars_.restamped_s >= options_.learned_rig.stamps.min_correction_s) {
    for (std::size_t i = 0; i < rig().radars.size(); ++i) {
      live_.submap.DropPoints(static_cast<int>(i));
    }
  }
}

// Where the vehicle's clock was set, nobody knows for how long it moved. Where radars were late,
// the pose was that of so long ago.
template <int Dim>
Motion Pipeline<Dim>::MotionSincePrevious(bool clock_was_set) const {
  Motion motion = ego_motion_.since_previous();
  const double unknown_s =
      std::hypot(clock_was_set ? options_.clock_set_sigma_s : 0.0, radars_.restamped_s);
  if (unknown_s > 0.0) {
    motion.covariance(0, 0) += std::pow(unknown_s * ego_motion_.velocity()->linear_mps.norm(), 2);
  }
  return motion;
}

template <int Dim>
void Pipeline<Dim>::Move(const Motion& motion) {
  pose_.OnMotion(motion);
  relocalizer_.OnMotion(motion, ego_motion_.spread_since_previous());
  const double distance_m = motion.T_from_to.translation_m.norm();
  radars_.range_biases.OnMotion(distance_m);
  claims_.protection_level.OnMotion(distance_m);
  claims_.reset_counter.OnMotion(ego_motion_.expected_motion());
  // The noise was learned with other sources in use.
  if (ego_motion_.sources_changed()) pose_.ResetNoise();
  if (HorizontalSigma(ego_motion_.spread_since_previous()) > options_.usual_spread_m) pose_.OnGap();
}

template <int Dim>
void Pipeline<Dim>::Compensate(const Scan& scan, Stamp stamp, const EgoVelocity& ego_velocity,
                               Workspace<Dim>& workspace) {
  const std::size_t radar_index = radars_.learned.IndexOf(scan.radar_id);
  const RadarModel& radar = radars_.learned.rig().radars[radar_index];
  std::vector<RadarPoint>& points = workspace.static_points;
  const Scan& measured = AsMeasured(scan, ego_velocity, workspace);
  StaticPoints(measured, radar, ego_velocity, EffectiveStaticPoints(options_), points);
  RangeRateErrors& errors = radars_.range_rate_errors;
  errors.OnScan(stamp, radar_index, measured, points.size(), radar, ego_velocity);
  if (!errors.Supposed(radar_index).is_none()) {
    workspace.rescaled_scan = measured;
    CorrectRangeRates(errors.Supposed(radar_index), radar, ego_velocity, workspace.rescaled_scan);
    StaticPoints(workspace.rescaled_scan, radar, ego_velocity, EffectiveStaticPoints(options_),
                 points);
  }
  radars_.monitor.OnScan(stamp, radar_index, scan.size(), points.size());
}

template <int Dim>
void Pipeline<Dim>::AddToSubmap(Stamp stamp, std::size_t radar_index,
                                const std::vector<RadarPoint>& points, const Motion& motion) {
  // The spread of the sources is left out. If those in use are wrong, they misplace new scans as
  // they did the old ones, and dropping these mends nothing.
  const Matrix6d gap = motion.covariance - ego_motion_.spread_since_previous();
  if (HorizontalSigma(gap) > options_.max_gap_sigma_m ||
      std::sqrt(gap(5, 5)) > options_.max_gap_sigma_rad) {
    live_.submap.Clear();
    pose_.OnGap();
  }
  live_.submap.Push(stamp, static_cast<int>(radar_index), points, motion);
  live_.schedule.OnScan(stamp, live_.submap.scan_count(), points.size());
}

// A new state, where odometry puts it, and the local map around it.
template <int Dim>
void Pipeline<Dim>::Predict(Stamp stamp, RegistrationWorkspace<Dim>& workspace) {
  if (!tracking_.has_pose()) return;
  pose_.AddState();
  ExpireTimeouts(stamp);
  EnterLocalFrame(NowInMap().pose.translation_m, workspace);
}

// The local map follows the vehicle; what the pose graph knows is re-expressed in its new frame.
template <int Dim>
void Pipeline<Dim>::EnterLocalFrame(const Eigen::Vector3d& p_map,
                                    RegistrationWorkspace<Dim>& workspace) {
  const Pose3 T_map_old = map_.matcher.T_map_local();
  if (!map_.matcher.MoveTo(p_map, workspace)) return;
  const Pose3 T_new_old = map_.matcher.T_map_local().Inverse() * T_map_old;
  pose_.ChangeFrame(FromSpace<Dim>(T_new_old, Matrix6d::Zero()).pose);
}

template <int Dim>
std::optional<typename Pipeline<Dim>::Registered> Pipeline<Dim>::Register(
    Stamp stamp, Workspace<Dim>& workspace) {
  const std::span<const GaussianPoint<Dim>> live = workspace.submap.points;
  std::optional<Registration<Dim>> registration;
  const std::optional<Place> place = SearchPlace(live, stamp, workspace.registration);
  const PlaceOrigin origin = place ? place->origin : PlaceOrigin::kExpected;
  if (place && origin == PlaceOrigin::kExpected) OnPoseVerified(place->fits_as_usual);
  if (origin == PlaceOrigin::kFound) {
    EnterLocalFrame(place->T_map_vehicle.translation_m, workspace.registration);
    registration = map_.matcher.MatchFound(live, place->T_map_vehicle, options_.global.gate,
                                           workspace.registration);
  } else if (tracking_.has_pose() && live_.schedule.has_new_points() && !IsVague()) {
    registration = map_.matcher.Match(live, pose_.Newest(), map_.observability,
                                      static_cast<std::uint64_t>(stamp.time_since_epoch().count()),
                                      workspace.registration);
  }
  if (!registration) return std::nullopt;
  newest_.quality.inlier_count = registration->inlier_count;
  newest_.quality.overlap = registration->overlap;
  newest_.quality.residual_scale = registration->residual_scale;
  return Registered{.registration = *registration, .origin = origin};
}

template <int Dim>
void Pipeline<Dim>::UpdateObservability(const Registration<Dim>& registration, Stamp stamp,
                                        Workspace<Dim>& workspace) {
  const bool is_decisive =
      ego_motion_.along_track_spread_m() > options_.ego_motion.sources.min_alternative_distance_m;
  if (!map_.observability_schedule.IsDue(stamp, live_.submap.span(), is_decisive)) return;
  map_.observability =
      map_.matcher.Observed(workspace.submap.points, registration, workspace.registration);
  tracking_.OnObservability(stamp, map_.observability.ObservesAll());
}

// A registration at a new place starts a pose graph; any other is a factor of the one there is.
template <int Dim>
RegistrationOutcome Pipeline<Dim>::UpdatePose(Stamp stamp,
                                              const std::optional<Registered>& registered,
                                              const EgoVelocity& ego_velocity,
                                              Workspace<Dim>& workspace) {
  if (!registered) return RegistrationOutcome::kNoMatch;
  const Registration<Dim>& registration = registered->registration;
  const std::chrono::nanoseconds span = live_.submap.span();
  registration_count_ = registered->origin == PlaceOrigin::kFound ? 1 : registration_count_ + 1;
  TangentMatrix<Dim> degeneracy = TangentMatrix<Dim>::Zero();
  degeneracy.template topLeftCorner<2, 2>() =
      map_.observability.DegeneracyCovariance(options_.matcher.observability.degenerate_sigma_m);
  const AbsolutePoseFactor<Dim> factor = RegistrationFactor<Dim>(
      registration, degeneracy,
      pose_.noise_scales().RegistrationCovariance(ResidualScaledCovariance<Dim>(registration)),
      CalibrationCovariance<Dim>(workspace.submap, radars_.learned.rig(), ego_velocity),
      {.interval = live_.schedule.SinceRegistration().value_or(span),
       .submap_span = span,
       .speed_mps = ego_velocity.linear_mps.norm(),
       .count = registration_count_},
      options_.factor);
  InnovationTest test{.is_accepted = true};
  if (registered->origin == PlaceOrigin::kExpected) {
    test = pose_.AddAbsolutePose(factor);
    const Tangent<Dim> residual = Log(pose_.Newest().pose.Inverse() * factor.pose);
    const double squared_distance_per_dof = test.squared_distance / Pose<Dim>::kDof;
    claims_.protection_level.OnInnovation(squared_distance_per_dof, residual.template head<2>());
    place_evidence_.OnInnovation(stamp, squared_distance_per_dof);
  } else {
    radars_.scan_checker.Reset();
    rivals_.OnPlaceFound();
    place_evidence_.Reset();
    radars_.azimuth_signs.Reset();
    radars_.range_biases.Reset();
    radars_.monitor.ResetFits();
    ego_motion_.OnPlaceChanged();
    pose_.Reset({.pose = factor.pose, .covariance = factor.covariance}, factor.systematic);
    tracking_.OnPlaceFound();
  }
  newest_.quality.normalized_innovation_squared = test.squared_distance;
  newest_.quality.is_accepted = test.is_accepted;
  return test.is_accepted ? RegistrationOutcome::kAccepted : RegistrationOutcome::kOutlier;
}

// Registrations measure the motion without the sources of odometry, which are held against them.
// While the pose is not confirmed, two in a row may be at two places, and teach nothing but a turn.
template <int Dim>
void Pipeline<Dim>::UpdateOdometry(const std::optional<Registered>& registered,
                                   RegistrationOutcome outcome) {
  const TrackingMode mode = tracking_.mode();
  if (mode != TrackingMode::kConfirmed) {
    ego_motion_.OnPoseDoubted(mode == TrackingMode::kSuspect ||
                              mode == TrackingMode::kDeadReckoning);
    pose_.OnDiscontinuity();
  }
  if (!registered) return;
  const PoseEstimate<3> T_local_vehicle =
      ToSpace<Dim>({.pose = registered->registration.T_local_vehicle}, options_.unobserved);
  ego_motion_.OnRegistration(map_.matcher.T_map_local() * T_local_vehicle.pose,
                             {.is_accepted = outcome == RegistrationOutcome::kAccepted,
                              .observes_along_track = map_.observability.Observed(VehicleAxis::kX),
                              .submap_age = live_.submap.span() / 2});
}

// So uncertain, where the ground repeats, that a registration would find some place that looks
// alike and call it certain, further from the right one than rivals are looked for.
template <int Dim>
bool Pipeline<Dim>::IsVague() const {
  return tracking_.is_lost() && rivals_.ground_repeats() &&
         HorizontalSigma(NowInMap().covariance) > options_.along_track_rivals.max_offset_m;
}

template <int Dim>
PoseEstimate<3> Pipeline<Dim>::NowInMap() const {
  const PoseEstimate<3> now = ToSpace<Dim>(pose_.Now(), options_.unobserved);
  return {.pose = map_.matcher.T_map_local() * now.pose, .covariance = now.covariance};
}

template class Pipeline<2>;
template class Pipeline<3>;

}  // namespace dcloc
