// Maps of drives without poses, beside maps of the same drives at their true poses.
#include <algorithm>
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

/// A drive in a map whose frame lies so in that of the truth.
Localized LocalizeIn(const std::vector<std::byte>& bytes, const Pose2& T_truth_map,
                     const Drive& drive) {
  const auto map = RadarMap::FromBytes(bytes).value();
  const Pose3 T_map_truth = Embed(T_truth_map.Inverse());
  InitialPose prior{.T_map_vehicle = T_map_truth * drive.scans.front().T_map_vehicle,
                    .covariance = 0.25 * Matrix6d::Identity()};
  Localizer localizer = Localizer::Create(map, drive.rig, prior).value();
  std::vector<double> errors_m;
  for (const DriveScan& entry : drive.scans) {
    const auto answer = localizer.Localize(entry.scan);
    if (!answer.ok() || answer->state != LocalizationState::kTracking) continue;
    const Pose3 T_map_vehicle = T_map_truth * entry.T_map_vehicle;
    errors_m.push_back(
        (answer->T_map_vehicle.translation_m - T_map_vehicle.translation_m).head<2>().norm());
  }
  if (errors_m.empty()) return {};
  std::ranges::sort(errors_m);
  return {.median_m = errors_m[errors_m.size() / 2],
          .p95_m = errors_m[errors_m.size() * 95 / 100],
          .tracking_share =
              static_cast<double>(errors_m.size()) / static_cast<double>(drive.scans.size())};
}

void Run(std::uint64_t seed, int radar_count) {
  const SimulationOptions options = Town(seed, radar_count);
  std::vector<Drive> drives;
  for (const PassOptions& pass : Passes(options)) {
    drives.push_back(SimulatePass(options, pass).value());
  }
  const Drive judge = std::move(drives.back());
  drives.pop_back();
  WholeDrives source(drives);
  SurveyBuilder builder(source, [](const char*, double) { return true; });
  absl::Status status = builder.Track();
  if (status.ok()) status = builder.Place({});
  if (!status.ok()) {
    std::printf("%-5lu %s\n", static_cast<unsigned long>(seed), status.ToString().c_str());
    return;
  }
  const Judgement judgement = Judge(builder, drives);
  const Localized surveyed =
      LocalizeIn(builder.Fuse({.name = "survey"}).value(), judgement.T_truth_map, judge);
  const Localized truth = LocalizeIn(MapOfTruth(drives), {}, judge);
  std::printf(
      "%-5lu %6d %6zu %8.3f %8.3f %6.2f %6zu %5zu   %6.3f %6.3f %5.1f   %6.3f %6.3f %5.1f\n",
      static_cast<unsigned long>(seed), radar_count, judgement.drive_count,
      judgement.before_loops_m, judgement.rmse_m, 1e3 * (judgement.scale - 1.0),
      judgement.loop_count, judgement.wrong_count, surveyed.median_m, surveyed.p95_m,
      100.0 * surveyed.tracking_share, truth.median_m, truth.p95_m, 100.0 * truth.tracking_share);
  std::fflush(stdout);
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s RADARS SEED...\n", argv[0]);
    return 2;
  }
  std::printf("%-5s %6s %6s %8s %8s %6s %6s %5s   %s\n", "seed", "radars", "drives", "before m",
              "rmse m", "per mil", "loops", "wrong",
              "p50 m, p95 m, tracking % in it; at true poses");
  for (int i = 2; i < argc; ++i) {
    dcloc::benchmarks::Run(std::strtoull(argv[i], nullptr, 10), std::atoi(argv[1]));
  }
  return 0;
}
