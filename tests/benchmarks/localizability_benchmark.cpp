// What a map says that vehicles can expect of it, beside what vehicles then get.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"
#include "core/localizability/localizability.h"
#include "core/localizer/localizer.h"

namespace dcloc::benchmarks {
namespace {

struct World {
  const char* name;
  SimulationOptions options;
};

std::vector<World> Worlds() {
  World town{.name = "town", .options = {}};
  World five{.name = "five", .options = {.rig_size = 5, .length_m = 600.0}};
  World tunnel{.name = "tunnel", .options = {.length_m = 1200.0, .tunnel_m = 300.0}};
  World highway{.name = "highway", .options = {.world = WorldKind::kHighway, .length_m = 2000.0}};
  highway.options.map_speed_mps = highway.options.live_speeds_mps[0] = 100.0 / 3.6;
  return {town, five, tunnel, highway};
}

/// What a vehicle got near a keyframe.
struct Got {
  int count = 0;
  int observed_count = 0;
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();      ///< along, across, heading: as told
  Eigen::Vector3d square_error = Eigen::Vector3d::Zero();  ///< as it was
  std::optional<bool> is_start_right;  ///< a vehicle without a pose found itself here in 30 m
};

double MedianOf(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Near which keyframe each scan was taken.
std::vector<std::optional<std::size_t>> KeyframesOf(const RadarMap& map, const Drive& drive) {
  std::vector<std::optional<std::size_t>> keyframes;
  for (const DriveScan& entry : drive.scans) {
    keyframes.push_back(map.NearestKeyframe(entry.T_map_vehicle.translation_m, 15.0));
  }
  return keyframes;
}

/// A vehicle that has learned on one drive what another one is then told.
void Localize(const std::shared_ptr<const RadarMap>& map, const Drive& before, const Drive& drive,
              std::vector<Got>& got) {
  const auto prior_at = [](const Pose3& pose) {
    return InitialPose{.T_map_vehicle = pose, .covariance = Matrix6d::Identity() * 0.01};
  };
  Localizer learner =
      Localizer::Create(map, before.rig, prior_at(before.scans.front().T_map_vehicle)).value();
  std::optional<LocalizerSnapshot> learned;
  for (const DriveScan& entry : before.scans) {
    if (!learner.Localize(entry.scan).ok()) continue;
    if (auto snapshot = learner.Snapshot()) learned = snapshot;
  }
  const auto keyframes = KeyframesOf(*map, drive);
  const DriveScan& first = drive.scans.front();
  Localizer localizer = Localizer::Create(map, drive.rig, prior_at(first.T_map_vehicle)).value();
  if (learned) {
    const EgoVelocity& velocity = *first.scan.ego_velocity;
    const Eigen::Vector3d back_m = -0.1 * velocity.linear_mps;
    learned->pose.T_map_vehicle = first.T_map_vehicle * Pose3{.translation_m = back_m};
    learned->stamp = first.scan.stamp - std::chrono::milliseconds(100);
    learned->velocity.linear_mps = velocity.linear_mps;
    if (!localizer.Restore(*learned).ok()) std::printf("not restored\n");
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const auto answer = localizer.Localize(drive.scans[i].scan);
    if (!answer.ok() || !keyframes[i]) continue;
    if (answer->state == LocalizationState::kInitializing) continue;
    Got& here = got[*keyframes[i]];
    const Vector6d error = Log(answer->T_map_vehicle.Inverse() * drive.scans[i].T_map_vehicle);
    ++here.count;
    if (answer->observed[0]) ++here.observed_count;
    for (int axis = 0; axis < 3; ++axis) {
      const int row = axis == 2 ? 5 : axis;
      here.variance(axis) += answer->covariance(row, row);
      here.square_error(axis) += error(row) * error(row);
    }
  }
}

void Start(const std::shared_ptr<const RadarMap>& map, const Drive& drive, std::vector<Got>& got) {
  // As far as an empty highway may be driven in three seconds.
  constexpr double kWithin_m = 80.0;
  const auto keyframes = KeyframesOf(*map, drive);
  for (std::size_t begin = 0; begin < drive.scans.size(); ++begin) {
    if (!keyframes[begin] || got[*keyframes[begin]].is_start_right) continue;
    Localizer localizer = Localizer::Create(map, drive.rig, std::nullopt).value();
    bool is_right = false;
    std::size_t i = begin;
    for (; i < drive.scans.size(); ++i) {
      const Pose3& truth = drive.scans[i].T_map_vehicle;
      if ((truth.translation_m - drive.scans[begin].T_map_vehicle.translation_m).norm() >
          kWithin_m) {
        break;
      }
      const auto answer = localizer.Localize(drive.scans[i].scan);
      if (!localizer.has_pose()) continue;
      is_right = (answer->T_map_vehicle.translation_m - truth.translation_m).norm() < 3.0;
      break;
    }
    if (i == drive.scans.size()) return;  // the drive ends before it could
    got[*keyframes[begin]].is_start_right = is_right;
  }
}

void Compare(const char* world, std::uint64_t seed, const std::vector<KeyframeLocalizability>& all,
             const std::vector<Got>& got) {
  std::vector<double> told[3], erred[3];
  int tunnel_both = 0, tunnel_said = 0, tunnel_got = 0;
  int alias_both = 0, alias_said = 0, alias_got = 0, starts = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (got[i].count < 5 || !all[i].is_known) continue;
    const double expected[] = {all[i].along_sigma_m, all[i].across_sigma_m,
                               all[i].heading_sigma_rad};
    for (int axis = 0; axis < 3; ++axis) {
      told[axis].push_back(expected[axis] / std::sqrt(got[i].variance(axis) / got[i].count));
      erred[axis].push_back(got[i].square_error(axis) / got[i].count /
                            (expected[axis] * expected[axis]));
    }
    const bool is_tunnel = got[i].observed_count * 2 < got[i].count;
    tunnel_said += all[i].is_tunnel ? 1 : 0;
    tunnel_got += is_tunnel ? 1 : 0;
    tunnel_both += is_tunnel && all[i].is_tunnel ? 1 : 0;
    if (!got[i].is_start_right) continue;
    ++starts;
    alias_said += all[i].alias || all[i].is_tunnel ? 1 : 0;
    alias_got += *got[i].is_start_right ? 0 : 1;
    alias_both += (all[i].alias || all[i].is_tunnel) && !*got[i].is_start_right ? 1 : 0;
  }
  std::printf("%-8s %4lu %5zu", world, static_cast<unsigned long>(seed), told[0].size());
  for (const auto& axis : told) std::printf(" %5.2f", MedianOf(axis));
  for (auto& axis : erred) {
    double sum = 0.0;
    for (const double value : axis) sum += value;
    std::printf(" %5.2f", sum / static_cast<double>(axis.size()));
  }
  std::printf("   %3d said %3d got %3d both   %3d said %3d got %3d both of %d\n", tunnel_said,
              tunnel_got, tunnel_both, alias_said, alias_got, alias_both, starts);
  std::fflush(stdout);
}

void Run(std::uint64_t seed) {
  for (World& world : Worlds()) {
    world.options.seed = seed;
    world.options.live_speeds_mps.push_back(world.options.live_speeds_mps[0]);
    const std::vector<PassOptions> passes = Passes(world.options);
    const Drive map_drive = SimulatePass(world.options, passes[0]).value();
    const Drive before = SimulatePass(world.options, passes[1]).value();
    const Drive live = SimulatePass(world.options, passes[2]).value();
    const auto map = RadarMap::FromBytes(BuildMap(map_drive, {.name = world.name}).value()).value();
    LocalizabilityOptions options;
    options.vehicle.rig = live.rig;
    options.vehicle.speed_mps = world.options.live_speeds_mps[0];
    const auto all = ComputeLocalizability(map, options, [](double) { return true; }).value();
    std::vector<Got> got(all.size());
    Localize(map, before, live, got);
    Start(map, live, got);
    Compare(world.name, seed, all, got);
  }
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s SEED...\n", argv[0]);
    return 2;
  }
  std::printf("%-8s %4s %5s %17s %17s   tunnels   starts that fail\n", "world", "seed", "n",
              "expected / told", "error / expected");
  for (int i = 1; i < argc; ++i) dcloc::benchmarks::Run(std::strtoull(argv[i], nullptr, 10));
  return 0;
}
