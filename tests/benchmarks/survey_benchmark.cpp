// Maps of drives without poses, beside maps of the same drives at their true poses.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/datasets/whole_drives.h"
#include "client/simulation/simulation.h"
#include "core/geometry/rigid_fit.h"
#include "core/localizer/localizer.h"
#include "core/map/map_builder.h"
#include "core/mapping/survey_builder.h"
#include "tests/benchmarks/inputs.h"

namespace dcloc::benchmarks {
namespace {

constexpr double kWrongLoop_m = 1.0;

/// A town whose street is a ring of a kilometre and a half, which each of five drives passes twice.
SimulationOptions Town(std::uint64_t seed, int radar_count) {
  SimulationOptions options;
  options.seed = seed;
  options.rig_size = radar_count;
  options.length_m = 3000.0;
  options.loop_m = 1500.0;
  options.map_speed_mps = 14.0;
  options.live_speeds_mps = {11.0, 14.0, 9.0, 11.0};
  return options;
}

/// The true poses of a drive's nodes.
std::vector<Pose2> TruthOf(const Drive& drive, const DriveTrack& track) {
  std::vector<Pose2> truth;
  std::size_t i = 0;
  for (const SurveyNode& node : track.nodes) {
    while (i + 1 < drive.scans.size() && drive.scans[i].scan.stamp < node.stamp) ++i;
    truth.push_back(Flatten(drive.scans[i].T_map_vehicle));
  }
  return truth;
}

struct Judgement {
  Pose2 T_truth_map;
  double rmse_m = 0.0;
  double before_loops_m = 0.0;  ///< RMSE of the worst drive
  std::size_t loop_count = 0;
  std::size_t wrong_count = 0;
  double scale = 1.0;
  std::size_t drive_count = 0;  ///< in the map
};

/// Of the map, beside the truth.
double ScaleOf(const std::vector<PlacePair>& pairs) {
  Eigen::Vector2d mean_a_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_b_m = Eigen::Vector2d::Zero();
  for (const PlacePair& pair : pairs) {
    mean_a_m += pair.p_a_m / static_cast<double>(pairs.size());
    mean_b_m += pair.p_b_m / static_cast<double>(pairs.size());
  }
  double a = 0.0;
  double b = 0.0;
  for (const PlacePair& pair : pairs) {
    a += (pair.p_a_m - mean_a_m).squaredNorm();
    b += (pair.p_b_m - mean_b_m).squaredNorm();
  }
  return std::sqrt(b / a);
}

double Rmse(const std::vector<PlacePair>& pairs, const Pose2& T_a_b) {
  double sum = 0.0;
  for (const PlacePair& pair : pairs) sum += (pair.p_a_m - T_a_b * pair.p_b_m).squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(pairs.size(), 1)));
}

Judgement Judge(const SurveyBuilder& builder, const std::vector<Drive>& drives) {
  const Survey& survey = builder.survey();
  Judgement judgement;
  std::vector<std::vector<Pose2>> truths;
  std::vector<PlacePair> all;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    truths.push_back(TruthOf(drives[i], builder.tracks()[i]));
    const SurveyedDrive& drive = survey.drives[i];
    if (!drive.is_in_map) continue;
    ++judgement.drive_count;
    std::vector<PlacePair> alone;
    for (std::size_t k = 0; k < truths[i].size(); ++k) {
      all.push_back({truths[i][k].translation_m, drive.T_map_nodes[k].translation_m});
      alone.push_back({truths[i][k].translation_m, drive.T_start_nodes[k].translation_m});
    }
    judgement.before_loops_m = std::max(judgement.before_loops_m, Rmse(alone, FitRigid(alone)));
  }
  judgement.T_truth_map = FitRigid(all);
  judgement.rmse_m = Rmse(all, judgement.T_truth_map);
  judgement.scale = ScaleOf(all);
  for (const SurveyLoop& loop : survey.loops) {
    if (!loop.is_accepted) continue;
    ++judgement.loop_count;
    const Pose2 T_from_to =
        truths[loop.drive_from][loop.node_from].Inverse() * truths[loop.drive_to][loop.node_to];
    const double off_m = (T_from_to.translation_m - loop.T_from_to.translation_m).norm();
    judgement.wrong_count += off_m > kWrongLoop_m ? 1 : 0;
  }
  return judgement;
}

std::vector<std::byte> MapOfTruth(const std::vector<Drive>& drives) {
  MapBuilder builder = MapBuilder::Create(drives[0].rig, {.name = "truth"}).value();
  for (const Drive& drive : drives) {
    if (&drive != drives.data()) builder.BeginPass();
    for (const DriveScan& entry : drive.scans) {
      builder.Add(entry.scan, entry.T_map_vehicle, *entry.scan.ego_velocity).IgnoreError();
    }
  }
  return builder.Build().value();
}

struct Localized {
  double median_m = 0.0;
  double p95_m = 0.0;
  double tracking_share = 0.0;
};

/// A drive in a map, in which the vehicle was at `T_map_vehicles` at its scans.
Localized LocalizeIn(const std::vector<std::byte>& bytes, const std::vector<Pose3>& T_map_vehicles,
                     const Drive& drive) {
  const auto map = RadarMap::FromBytes(bytes).value();
  Vector6d sigmas;
  sigmas << 0.5, 0.5, 0.5, 0.035, 0.035, 0.035;  // of position [m] and rotation [rad]
  const InitialPose prior{T_map_vehicles.front(), sigmas.cwiseAbs2().asDiagonal()};
  Localizer localizer = Localizer::Create(map, drive.rig, prior).value();
  std::vector<double> errors_m;
  double tracking_count = 0.0;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto answer = localizer.Localize(drive.scans[i].scan);
    if (!answer.ok() || (answer->state != LocalizationState::kTracking &&
                         answer->state != LocalizationState::kDeadReckoning)) {
      continue;
    }
    tracking_count += answer->state == LocalizationState::kTracking ? 1.0 : 0.0;
    errors_m.push_back(
        (answer->T_map_vehicle.translation_m - T_map_vehicles[i].translation_m).head<2>().norm());
  }
  if (errors_m.empty()) return {};
  std::ranges::sort(errors_m);
  return {.median_m = errors_m[errors_m.size() / 2],
          .p95_m = errors_m[errors_m.size() * 95 / 100],
          .tracking_share = tracking_count / static_cast<double>(drive.scans.size())};
}

/// By the data set, in a map that lies so in its frame.
std::vector<Pose3> TrueIn(const Pose2& T_truth_map, const Drive& drive) {
  std::vector<Pose3> poses;
  for (const DriveScan& entry : drive.scans) {
    poses.push_back(Embed(T_truth_map.Inverse()) * entry.T_map_vehicle);
  }
  return poses;
}

/// By the survey, of a drive whose other radars it was made with.
std::vector<Pose3> SurveyedIn(const SurveyBuilder& builder, const Drive& drive) {
  const DriveTrack& track = builder.tracks()[0];
  const std::vector<Pose2>& T_map_nodes = builder.survey().drives[0].T_map_nodes;
  std::vector<Pose3> poses;
  std::size_t next = 1;
  for (const DriveScan& entry : drive.scans) {
    while (next + 1 < track.scans.size() && track.scans[next].stamp < entry.scan.stamp) ++next;
    const TrackedScan& before = track.scans[next - 1];
    const TrackedScan& after = track.scans[next];
    const double share = std::chrono::duration<double>(entry.scan.stamp - before.stamp) /
                         std::chrono::duration<double>(after.stamp - before.stamp);
    const Pose2 T_map_before = PlaceScan(track, T_map_nodes, before);
    const Pose2 moved = T_map_before.Inverse() * PlaceScan(track, T_map_nodes, after);
    poses.push_back(Embed(T_map_before * Exp(Eigen::Vector3d(share * Log(moved)))));
  }
  return poses;
}

/// Surveys `drives`, and localizes `judge` in what comes of it. `is_same_drive` where that is the
/// only one of them by other radars.
void SurveyAndJudge(const std::string& name, const std::vector<Drive>& drives, const Drive& judge,
                    bool is_same_drive) {
  WholeDrives source(drives);
  SurveyBuilder builder(source, [](const char*, double) { return true; });
  absl::Status status = builder.Track();
  if (status.ok()) status = builder.Place({});
  if (status.ok()) status = builder.Calibrate({});
  if (status.ok()) status = builder.CorrectScale();
  if (!status.ok()) {
    std::printf("%-16s %s\n", name.c_str(), status.ToString().c_str());
    return;
  }
  const Judgement judgement = Judge(builder, drives);
  const std::vector<std::byte> map = builder.Fuse({.name = "survey"}).value();
  const Localized surveyed = LocalizeIn(map, TrueIn(judgement.T_truth_map, judge), judge);
  const Localized truth = LocalizeIn(MapOfTruth(drives), TrueIn({}, judge), judge);
  std::printf(
      "%-16s %6zu %6zu %8.3f %8.3f %6.2f %6zu %5zu   %6.3f %6.3f %5.1f   %6.3f %6.3f %5.1f\n",
      name.c_str(), drives[0].rig.radars.size(), judgement.drive_count, judgement.before_loops_m,
      judgement.rmse_m, 1e3 * (judgement.scale - 1.0), judgement.loop_count, judgement.wrong_count,
      surveyed.median_m, surveyed.p95_m, 100.0 * surveyed.tracking_share, truth.median_m,
      truth.p95_m, 100.0 * truth.tracking_share);
  if (is_same_drive) {
    const Localized own = LocalizeIn(map, SurveyedIn(builder, judge), judge);
    std::printf("%-16s beside where the survey has the vehicle then: p50 %.3f m, p95 %.3f m\n",
                name.c_str(), own.median_m, own.p95_m);
  }
  std::fflush(stdout);
}

void SurveyTown(std::uint64_t seed, int radar_count, bool both_ways) {
  SimulationOptions options = Town(seed, radar_count);
  options.both_ways = both_ways;
  std::vector<Drive> drives;
  for (const PassOptions& pass : Passes(options)) {
    drives.push_back(SimulatePass(options, pass).value());
  }
  const Drive judge = std::move(drives.back());
  drives.pop_back();
  SurveyAndJudge(std::to_string(seed), drives, judge, /*is_same_drive=*/false);
}

/// What the radars that look the other way make of a recorded drive, without its poses.
void SurveyRecordings() {
  const std::vector<Case> cases = RecordedCases();
  if (cases.empty()) std::fprintf(stderr, "skipped: DCLOC_DATA names no recordings\n");
  for (const Case& recorded : cases) {
    SurveyAndJudge(recorded.name, {recorded.map_drive}, recorded.live_drive,
                   /*is_same_drive=*/true);
  }
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const std::string kind = argc > 1 ? argv[1] : "";
  if (kind != "recordings" && argc < 3) {
    std::fprintf(stderr,
                 "usage: %s RADARS SEED...     towns, all drives the same way round\n"
                 "       %s RADARS both SEED... towns, every second drive the other way round\n"
                 "       %s recordings\n",
                 argv[0], argv[0], argv[0]);
    return 2;
  }
  std::printf("%-16s %6s %6s %8s %8s %6s %6s %5s   %s\n", "seed or drive", "radars", "drives",
              "before m", "rmse m", "per mil", "loops", "wrong",
              "p50 m, p95 m, tracking % in it; at true poses");
  if (kind == "recordings") {
    SurveyRecordings();
    return 0;
  }
  const bool both_ways = std::string(argv[2]) == "both";
  for (int i = both_ways ? 3 : 2; i < argc; ++i) {
    SurveyTown(std::strtoull(argv[i], nullptr, 10), std::atoi(argv[1]), both_ways);
  }
  return 0;
}
