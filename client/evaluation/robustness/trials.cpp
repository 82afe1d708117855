#include "client/evaluation/robustness/trials.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <utility>

#include "client/datasets/files/check_range.h"
#include "client/evaluation/robustness/judgement.h"
#include "client/evaluation/runner.h"
#include "core/relocalization/gnss_prior.h"

namespace dcloc::robustness {
namespace {

using Map = std::shared_ptr<const RadarMap>;
using Tell = std::function<void(double)>;

std::chrono::nanoseconds Duration(double seconds) {
  return std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

Stamp FirstStamp(const Drive& drive) { return drive.scans.front().scan.stamp; }

// The drive in parts of `session_s`; a rest that is too short for a session stays out.
std::vector<Drive> Parts(const Drive& drive, double session_s) {
  const auto length = Duration(session_s);
  std::vector<Drive> parts;
  for (const DriveScan& entry : drive.scans) {
    const bool is_full = parts.empty() || entry.scan.stamp - FirstStamp(parts.back()) >= length;
    if (is_full) {
      parts.push_back({drive.name, drive.place, drive.rig, {}});
    }
    parts.back().scans.push_back(entry);
  }
  const Drive& last = parts.back();
  if (parts.size() > 1 && last.scans.back().scan.stamp - FirstStamp(last) < length / 2) {
    parts.pop_back();
  }
  return parts;
}

absl::StatusOr<Tally> TrackOnce(const TrackTrial& trial, const Drive& live,
                                const std::vector<Episode>& episodes, std::uint64_t part,
                                const Map& map, const Tell& progress) {
  DisturbedDrive disturbed{.drive = live, .touched = {}, .episodes = episodes};
  EvaluationOptions options{.perturbation = trial.prior};
  options.perturbation.seed += part;
  if (trial.plan) {
    DisturbancePlan plan = *trial.plan;
    plan.seed += part;
    auto made = Disturb(live, plan);
    if (!made.ok()) return made.status();
    disturbed = *std::move(made);
  }
  const auto outcome = Evaluate(map, disturbed.drive, options, progress);
  if (!outcome.ok()) return outcome.status();
  return JudgeTrack(*outcome, disturbed.episodes);
}

absl::StatusOr<Tally> RunTrack(const TrackTrial& trial, const Course& course, const Map& map,
                               const Tell& progress) {
  if (!trial.session_s) {
    return TrackOnce(trial, course.live, course.episodes, 0, map, progress);
  }
  Tally tally;
  const std::vector<Drive> parts = Parts(course.live, *trial.session_s);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto tell = [&](double share) {
      progress((static_cast<double>(i) + share) / static_cast<double>(parts.size()));
    };
    auto part = TrackOnce(trial, parts[i], {}, i, map, tell);
    if (!part.ok()) return part.status();
    // Incidents are dated from the drive's beginning.
    const std::chrono::duration<double> before = FirstStamp(parts[i]) - FirstStamp(course.live);
    for (Incident& incident : part->incidents) incident.at_s += before.count();
    Merge(*part, tally);
  }
  return tally;
}

// As the server takes a fix without a heading. Where on the Earth the map lies does not matter.
InitialPose PriorFromFix(const Pose3& T_map_vehicle_true, double sigma_m, std::mt19937_64& random) {
  constexpr GeodeticAnchor kAnchor{.origin = {.latitude_deg = 48.0, .longitude_deg = 11.0}};
  std::normal_distribution<double> error(0.0, sigma_m);
  Eigen::Vector3d p_map = T_map_vehicle_true.translation_m;
  p_map.x() += error(random);
  p_map.y() += error(random);
  return PriorFromGnss({.position = GeodeticFromMap(kAnchor, p_map),
                        .horizontal_sigma_m = sigma_m,
                        .vertical_sigma_m = sigma_m},
                       kAnchor);
}

std::optional<InitialPose> PriorOf(const StartTrial& trial, const Drive& drive, std::size_t begin,
                                   std::uint64_t number) {
  const Pose3& truth = drive.scans[begin].T_map_vehicle;
  switch (trial.prior) {
    case Prior::kPose:
      return Perturb(truth, trial.perturbation, drive.name, number);
    case Prior::kGnss: {
      std::seed_seq seeds{trial.perturbation.seed, number};
      std::mt19937_64 random(seeds);
      return PriorFromFix(truth, trial.perturbation.translation_m, random);
    }
    case Prior::kNone:
      return std::nullopt;
  }
  return std::nullopt;
}

absl::StatusOr<Tally> StartAt(const StartTrial& trial, const Course& course, std::size_t begin,
                              std::uint64_t number, const Map& map) {
  const Drive& drive = course.live;
  auto localizer =
      Localizer::Create(map, drive.rig, PriorOf(trial, drive, begin, number), LocalizerOptions{});
  if (!localizer.ok()) return localizer.status();
  DriveOutcome outcome{.drive = drive.name};
  const Stamp limit = drive.scans[begin].scan.stamp + Duration(trial.limit_s);
  for (std::size_t i = begin; i < drive.scans.size(); ++i) {
    const auto& [scan, T_map_vehicle] = drive.scans[i];
    if (scan.stamp > limit) break;
    const auto answer = localizer->Localize(scan);
    if (!answer.ok()) {
      ++outcome.refused_count;
      continue;
    }
    outcome.scans.push_back({.radar_id = scan.radar_id,
                             .answer = *answer,
                             .T_map_vehicle_true = T_map_vehicle,
                             .error = ComparePoses(answer->T_map_vehicle, answer->covariance,
                                                   answer->observed, T_map_vehicle)});
    if (answer->state == LocalizationState::kTracking) break;
  }
  return JudgeStart(outcome, FirstStamp(drive));
}

// Where sessions start: every `spacing_m` of the path, while there is data enough after it.
std::vector<std::size_t> StartIndices(const Drive& drive, const StartTrial& trial) {
  const Stamp last = drive.scans.back().scan.stamp - Duration(trial.limit_s);
  std::vector<std::size_t> indices;
  double way_m = trial.spacing_m;
  for (std::size_t i = 0; i < drive.scans.size() && drive.scans[i].scan.stamp <= last; ++i) {
    if (i > 0) {
      way_m += (drive.scans[i].T_map_vehicle.translation_m -
                drive.scans[i - 1].T_map_vehicle.translation_m)
                   .norm();
    }
    if (way_m < trial.spacing_m) continue;
    way_m = std::fmod(way_m, trial.spacing_m);
    indices.push_back(i);
  }
  return indices;
}

absl::StatusOr<Tally> RunStarts(const StartTrial& trial, const Course& course, const Map& map,
                                const Tell& progress) {
  Tally tally;
  const std::vector<std::size_t> indices = StartIndices(course.live, trial);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto start = StartAt(trial, course, indices[i], i, map);
    if (!start.ok()) return start.status();
    Merge(*start, tally);
    progress(static_cast<double>(i + 1) / static_cast<double>(indices.size()));
  }
  return tally;
}

}  // namespace

absl::Status Validate(const Trial& trial) {
  if (const auto* track = std::get_if<TrackTrial>(&trial)) {
    absl::Status status = Validate(track->prior);
    if (track->plan) status.Update(Validate(*track->plan));
    if (track->session_s) status.Update(CheckRange("session_s", *track->session_s, 1.0, 1e6));
    return status;
  }
  const auto& start = std::get<StartTrial>(trial);
  absl::Status status = Validate(start.perturbation);
  status.Update(CheckRange("spacing_m", start.spacing_m, 0.1, 1e6));
  status.Update(CheckRange("limit_s", start.limit_s, 0.1, 1e6));
  return status;
}

absl::StatusOr<Tally> RunTrial(const Trial& trial, const Course& course, const Map& map,
                               const Tell& progress) {
  if (absl::Status status = Validate(trial); !status.ok()) return status;
  if (map == nullptr) return absl::InvalidArgumentError("map is null");
  if (course.live.scans.empty()) {
    return absl::InvalidArgumentError("drive " + course.live.name + " has no scans");
  }
  if (const auto* track = std::get_if<TrackTrial>(&trial)) {
    return RunTrack(*track, course, map, progress);
  }
  return RunStarts(std::get<StartTrial>(trial), course, map, progress);
}

}  // namespace dcloc::robustness
