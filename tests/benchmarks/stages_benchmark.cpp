// One benchmark for each stage of a scan and each thing done to a map, on frozen inputs.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/datasets/drive_map.h"
#include "core/localizer/localizer.h"
#include "core/odometry/ego_motion.h"
#include "core/posegraph/pose_chains.h"
#include "core/registration/correlative_search.h"
#include "core/registration/gicp.h"
#include "core/registration/radial_statistics.h"
#include "core/registration/rigid_ransac.h"
#include "tests/benchmarks/inputs.h"

namespace dcloc::benchmarks {
namespace {

constexpr double kLength_m = 300.0;
constexpr double kSearchedLength_m = 1000.0;

// What a tracker starts from: the fused state, carried on for one scan.
constexpr double kTracking_m = 0.03;
constexpr double kTracking_deg = 0.1;

// This thread's own time, so that a busy machine changes little.
double CpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Inputs {
  Case drives;
  std::vector<Query> queries;
};

const Inputs& InputsOf(const std::string& name, double length_m = kLength_m) {
  static std::map<std::pair<std::string, double>, Inputs> all;
  auto found = all.find({name, length_m});
  if (found == all.end()) {
    Inputs inputs{SimulatedCase(name, length_m), {}};
    constexpr std::size_t kCount = 12;
    inputs.queries = Queries(inputs.drives, inputs.drives.live_drive.scans.size() / kCount, kCount);
    found = all.emplace(std::pair(name, length_m), std::move(inputs)).first;
  }
  return found->second;
}

void Compensation(benchmark::State& state, const std::string& name) {
  const Drive& drive = InputsOf(name).drives.live_drive;
  const LocalizerOptions options;
  EgoMotion ego_motion(options.ego_motion);
  std::size_t i = 0;
  while (state.KeepRunning()) {
    if (i == drive.scans.size()) {
      ego_motion = EgoMotion(options.ego_motion);
      i = 0;
    }
    const Scan& scan = drive.scans[i++].scan;
    const RadarModel& radar = *drive.rig.Find(scan.radar_id);
    const EgoVelocity& velocity = ego_motion.Advance(scan, radar);
    benchmark::DoNotOptimize(StaticPoints(scan, radar, velocity, options.static_points));
  }
}

void JoinSubmap(benchmark::State& state, const std::string& name) {
  const Drive& drive = InputsOf(name).drives.live_drive;
  const LocalizerOptions options;
  EgoMotion ego_motion(options.ego_motion);
  SubmapWindow window(options.scans_per_submap);
  for (std::size_t i = 0; i < 50; ++i) {
    const Scan& scan = drive.scans[i].scan;
    const RadarModel& radar = *drive.rig.Find(scan.radar_id);
    const EgoVelocity& velocity = ego_motion.Advance(scan, radar);
    window.Push(scan.stamp, 0, StaticPoints(scan, radar, velocity, options.static_points),
                ego_motion.since_previous());
  }
  LiveSubmap<2> submap;
  while (state.KeepRunning()) {
    window.Join<2>(DriftCovariance::kAdded, static_cast<std::size_t>(options.max_submap_points),
                   submap);
    benchmark::DoNotOptimize(submap.points.data());
  }
  state.counters["points"] = static_cast<double>(submap.points.size());
}

// Calls `run(query, number)` for one query after another.
template <typename Run>
void ForQueries(benchmark::State& state, const Inputs& inputs, const Run& run) {
  const std::vector<Query>& queries = inputs.queries;
  std::size_t number = 0;
  double points = 0.0;
  double landmarks = 0.0;
  while (state.KeepRunning()) {
    const Query& query = queries[number % queries.size()];
    run(query, number % queries.size());
    points += static_cast<double>(query.live.size());
    landmarks += static_cast<double>(query.local_map.points().size());
    ++number;
  }
  state.counters["points"] = benchmark::Counter(points, benchmark::Counter::kAvgIterations);
  state.counters["landmarks"] = benchmark::Counter(landmarks, benchmark::Counter::kAvgIterations);
}

void Gicp(benchmark::State& state, const std::string& name) {
  double iterations = 0.0;
  CorrespondenceFinder<2> finder;
  ForQueries(state, InputsOf(name), [&](const Query& query, std::size_t number) {
    const Pose2 start = StartFor(query, number, kTracking_m, kTracking_deg);
    const auto result = RegisterGicp<2>(query.live, query.local_map, start, {}, finder);
    iterations += result.iterations;
  });
  state.counters["steps"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
}

template <typename Point>
std::vector<Eigen::Vector2f> PointsOf(std::span<const Point> points, std::size_t count) {
  std::vector<Eigen::Vector2f> chosen;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / count) {
    chosen.push_back(points[i].mean_m.template cast<float>());
  }
  return chosen;
}

void MakeLikelihoodField(benchmark::State& state, const std::string& name) {
  ForQueries(state, InputsOf(name), [&](const Query& query, std::size_t) {
    benchmark::DoNotOptimize(LikelihoodField(query.local_map, 0.25));
  });
}

void Correlate(benchmark::State& state, const std::string& name) {
  std::vector<LikelihoodField> fields;
  fields.reserve(InputsOf(name).queries.size());
  for (const Query& query : InputsOf(name).queries) fields.emplace_back(query.local_map, 0.25);
  ForQueries(state, InputsOf(name), [&](const Query& query, std::size_t number) {
    const SearchWindow window{.centre_local_vehicle = StartFor(query, number, 1.0, 2.0),
                              .translation_m = 3.0,
                              .rotation_rad = 0.1};
    benchmark::DoNotOptimize(
        CorrelativeSearch(PointsOf(std::span(query.live), 300), fields[number], window, 4));
  });
}

void DescribeAndRansac(benchmark::State& state, const std::string& name) {
  ForQueries(state, InputsOf(name), [&](const Query& query, std::size_t) {
    const auto landmarks = PointsOf(query.local_map.points(), 1200);
    const auto points = PointsOf(std::span(query.live), 300);
    const auto pairs = MutualNearest(RadialStatistics(landmarks), RadialStatistics(points), 2);
    benchmark::DoNotOptimize(MatchRigid(landmarks, points, pairs, 1));
  });
}

void SolvePoseGraph(benchmark::State& state) {
  PoseChains<2> graph{PoseGraphOptions{}};
  const auto spread = [](double sigma_m, double sigma_rad) -> Eigen::Matrix3d {
    return Eigen::Vector3d(sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad)
        .asDiagonal();
  };
  graph.Reset({{}, spread(0.1, 0.01)});
  const Eigen::Vector3d step(0.8, 0.0, 0.01);
  Pose2 truth;
  double side_m = 0.03;
  while (state.KeepRunning()) {
    truth = truth * Exp(step);
    graph.AddState({Exp(Eigen::Vector3d(1.01 * step)), spread(0.05, 0.003)});
    side_m = -side_m;
    graph.AddAbsolutePose({truth * Exp(Eigen::Vector3d(side_m, side_m, 0.1 * side_m)),
                           spread(0.06, 0.004), spread(0.2, 0.01)});
  }
  if (!graph.empty()) benchmark::DoNotOptimize(graph.Newest());
}

void EnterLocalMap(benchmark::State& state, const std::string& name) {
  const Case& drives = InputsOf(name).drives;
  std::size_t i = 0;
  while (state.KeepRunning()) {
    const DriveScan& at = drives.live_drive.scans[i++ * 20 % drives.live_drive.scans.size()];
    benchmark::DoNotOptimize(LocalMap<2>(*drives.map, at.T_map_vehicle.translation_m, 100.0));
  }
}

void QueryNearestKeyframe(benchmark::State& state, const std::string& name) {
  const Case& drives = InputsOf(name).drives;
  std::size_t i = 0;
  while (state.KeepRunning()) {
    const DriveScan& at = drives.live_drive.scans[i++ % drives.live_drive.scans.size()];
    benchmark::DoNotOptimize(drives.map->NearestKeyframe(at.T_map_vehicle.translation_m, 100.0));
  }
}

void OpenMap(benchmark::State& state, const std::string& name) {
  const std::vector<std::byte>& bytes = InputsOf(name).drives.map_bytes;
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("dcloc_benchmark_" + name + ".dclm");
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  while (state.KeepRunning()) benchmark::DoNotOptimize(RadarMap::Open(path));
  std::filesystem::remove(path);
  state.counters["bytes"] = static_cast<double>(bytes.size());
}

// Seconds of drive that are mapped in one second.
void BuildMapOf(benchmark::State& state, const std::string& name) {
  const Case& drives = InputsOf(name).drives;
  const std::vector<DriveScan>& scans = drives.map_drive.scans;
  while (state.KeepRunning()) benchmark::DoNotOptimize(BuildMap(drives.map_drive, {}));
  const double drive_s =
      std::chrono::duration<double>(scans.back().scan.stamp - scans.front().scan.stamp).count();
  state.counters["times_real"] =
      benchmark::Counter(drive_s, benchmark::Counter::kIsIterationInvariantRate);
}

// What one start costs.
struct Start {
  double work_ms = 0.0;     // of all scans until the first that tracks
  double longest_ms = 0.0;  // of a scan: so long others on the thread wait
  double data_s = 0.0;
  bool is_found = false;
};

// From nothing, with the drive's scan `begin` on.
Start StartAt(const Case& drives, std::size_t begin) {
  const std::vector<DriveScan>& scans = drives.live_drive.scans;
  auto localizer = Localizer::Create(drives.map, drives.live_drive.rig, std::nullopt);
  if (!localizer.ok()) std::abort();  // its inputs are ours
  Start start;
  for (std::size_t i = begin; i < scans.size() && !start.is_found; ++i) {
    const double begin_ms = CpuMilliseconds();
    const auto answer = localizer->Localize(scans[i].scan);
    const double ms = CpuMilliseconds() - begin_ms;
    start.work_ms += ms;
    start.longest_ms = std::max(start.longest_ms, ms);
    start.data_s =
        std::chrono::duration<double>(scans[i].scan.stamp - scans[begin].scan.stamp).count();
    start.is_found = answer.ok() && answer->state == LocalizationState::kTracking;
  }
  return start;
}

// Starts from nothing, along the drive; its end is left for the last one to be found on.
void StartFromNothing(benchmark::State& state, const std::string& name) {
  constexpr std::size_t kPlaces = 20;
  const Case& drives = InputsOf(name, kSearchedLength_m).drives;
  const std::size_t stride = drives.live_drive.scans.size() / (kPlaces + 2);
  std::vector<double> works_ms;
  Start sum;
  int found_count = 0;
  while (state.KeepRunning()) {
    const Start start = StartAt(drives, works_ms.size() % kPlaces * stride);
    state.SetIterationTime(1e-3 * start.work_ms);
    works_ms.push_back(start.work_ms);
    sum.longest_ms = std::max(sum.longest_ms, start.longest_ms);
    sum.data_s += start.data_s;
    found_count += start.is_found ? 1 : 0;
  }
  const auto count = static_cast<double>(works_ms.size());
  std::ranges::sort(works_ms);
  state.counters["p50_ms"] = works_ms[works_ms.size() / 2];
  state.counters["max_ms"] = works_ms.back();
  state.counters["longest_ms"] = sum.longest_ms;
  state.counters["data_s"] = sum.data_s / count;
  state.counters["found"] = found_count / count;
  state.counters["map_m"] = drives.map->info().length_m;
}

BENCHMARK_CAPTURE(Compensation, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Compensation, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(JoinSubmap, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(JoinSubmap, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Gicp, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Gicp, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(MakeLikelihoodField, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(MakeLikelihoodField, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Correlate, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Correlate, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DescribeAndRansac, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DescribeAndRansac, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(EnterLocalMap, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(EnterLocalMap, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(QueryNearestKeyframe, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(QueryNearestKeyframe, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(OpenMap, ars408, "ars408")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(OpenMap, carla, "carla")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BuildMapOf, ars408, "ars408")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BuildMapOf, carla, "carla")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(StartFromNothing, ars408, "ars408")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(StartFromNothing, carla, "carla")->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(SolvePoseGraph)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
