// Registration of the same sub-maps from the same starts by dcloc, the Point Cloud Library and
// Ceres: time, error and success of each.
#include <ceres/ceres.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "client/evaluation/baselines/pcl_registration.h"
#include "core/registration/correlative_search.h"
#include "core/registration/gicp.h"
#include "tests/benchmarks/inputs.h"

namespace dcloc::benchmarks {
namespace {

using Method = std::function<std::optional<Pose2>(const Query& query, const Pose2& start)>;

double CpuMilliseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

std::optional<Pose2> ByDcloc(const Query& query, const Pose2& start) {
  return RegisterGicp<2>(query.live, query.local_map, start).T_local_vehicle;
}

// The field is made anew each time, as for a prediction that has just become uncertain.
std::optional<Pose2> ByDclocSearch(const Query& query, const Pose2& start) {
  std::vector<Eigen::Vector2f> points;
  for (std::size_t i = 0; i < query.live.size(); i += 1 + query.live.size() / 300) {
    points.push_back(query.live[i].mean_m.cast<float>());
  }
  const LikelihoodField field(query.local_map, 0.25);
  const SearchWindow window{
      .centre_local_vehicle = start, .translation_m = 2.0, .rotation_rad = 0.1};
  std::optional<Registration<2>> best;
  for (const PoseCandidate& found : CorrelativeSearch(points, field, window, 3)) {
    const auto refined = RegisterGicp<2>(query.live, query.local_map, found.T_local_vehicle,
                                         {.initial_blur_m = 0.3});
    if (!best || refined.score > best->score) best = refined;
  }
  if (!best) return std::nullopt;
  return best->T_local_vehicle;
}

Method ByPlanar(const PlanarRegistration& planar) {
  return [&planar](const Query& query, const Pose2& start) -> std::optional<Pose2> {
    const auto fit = planar.Register(query.live, query.local_map, start, 1);
    if (!fit) return std::nullopt;
    return fit->T_local_vehicle;
  };
}

struct WhitenedDifference {
  Eigen::Vector2d q, p;
  Eigen::Matrix2d root;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    const T c = ceres::cos(pose[2]);
    const T s = ceres::sin(pose[2]);
    const T x = q.x() - (c * p.x() - s * p.y() + pose[0]);
    const T y = q.y() - (s * p.x() + c * p.y() + pose[1]);
    residual[0] = root(0, 0) * x + root(0, 1) * y;
    residual[1] = root(1, 0) * x + root(1, 1) * y;
    return true;
  }
};

// One round of Ceres on dcloc's own cost, its matches and weights frozen at `at`.
void AddMatches(const Query& query, const Pose2& at, ceres::Problem& problem, double* pose) {
  const GicpOptions options;
  const Eigen::Matrix2d R = at.Rotation();
  for (const auto& live : query.live) {
    const Eigen::Vector2d p = R * live.mean_m + at.translation_m;
    const Eigen::Matrix2d covariance = R * live.covariance_m2 * R.transpose();
    double best = std::numeric_limits<double>::infinity();
    WhitenedDifference match;
    query.local_map.ForEachNear(
        p.x(), p.y(), options.max_correspondence_distance_m, [&](std::size_t index) {
          const PackedPoint<2>& landmark = query.local_map.points()[index];
          const Eigen::Vector2d e = landmark.mean_m.cast<double>() - p;
          const Eigen::Matrix2d joint = landmark.Covariance_m2() + covariance;
          const Eigen::Matrix2d information = joint.inverse();
          const double distance = e.dot(information * e);
          if (distance > options.gate_sigmas * options.gate_sigmas) return;
          const double cost = distance + std::log(joint.determinant());
          if (cost >= best) return;
          best = cost;
          match = {landmark.mean_m.cast<double>(), live.mean_m, information.llt().matrixU()};
        });
    if (!std::isfinite(best)) continue;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<WhitenedDifference, 2, 3>(new WhitenedDifference(match)),
        new ceres::HuberLoss(options.huber_sigmas), pose);
  }
}

std::optional<Pose2> ByCeres(const Query& query, const Pose2& start) {
  Pose2 at = start;
  for (int round = 0; round < 30; ++round) {
    Eigen::Vector3d pose(at.translation_m.x(), at.translation_m.y(), at.yaw_rad);
    ceres::Problem problem;
    AddMatches(query, at, problem, pose.data());
    if (problem.NumResidualBlocks() == 0) return std::nullopt;
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 3;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    const Pose2 next{.translation_m = pose.head<2>(), .yaw_rad = WrapAngle(pose.z())};
    const Eigen::Vector3d step = Log(at.Inverse() * next);
    at = next;
    if (step.head<2>().norm() < 1e-3 && std::abs(step.z()) < 1e-4) break;
  }
  return at;
}

struct Figures {
  std::vector<double> times_ms;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  int success_count = 0;
};

double Quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

Figures Run(const Method& method, const std::vector<Query>& queries, double off_m, double off_deg) {
  constexpr double kSuccess_m = 0.3;
  constexpr double kSuccess_deg = 0.5;
  Figures figures;
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const Pose2 start = StartFor(queries[i], i, off_m, off_deg);
    const double begin_ms = CpuMilliseconds();
    const Pose2 found = method(queries[i], start).value_or(start);
    figures.times_ms.push_back(CpuMilliseconds() - begin_ms);
    const Pose2 error = queries[i].T_local_vehicle_true.Inverse() * found;
    figures.errors_m.push_back(error.translation_m.norm());
    figures.errors_deg.push_back(std::abs(error.yaw_rad) * 180.0 / std::numbers::pi);
    if (figures.errors_m.back() < kSuccess_m && figures.errors_deg.back() < kSuccess_deg) {
      ++figures.success_count;
    }
  }
  return figures;
}

void Compare(const Case& drives, std::size_t stride, std::size_t max_count) {
  const std::vector<Query> queries = Queries(drives, stride, max_count);
  const std::unique_ptr<PlanarRegistration> icp = MakeIcpRegistration();
  const std::unique_ptr<PlanarRegistration> gicp = MakePclGicpRegistration();
  const std::unique_ptr<PlanarRegistration> ndt = MakeNdtRegistration();
  const std::pair<const char*, Method> methods[] = {
      {"dcloc GICP", ByDcloc},       {"dcloc search + GICP", ByDclocSearch},
      {"Ceres, same cost", ByCeres}, {"PCL ICP", ByPlanar(*icp)},
      {"PCL GICP", ByPlanar(*gicp)}, {"PCL NDT 2D", ByPlanar(*ndt)}};
  const std::pair<double, double> starts[] = {{0.1, 0.3}, {0.5, 1.0}, {1.0, 2.0}};
  for (const auto& [off_m, off_deg] : starts) {
    for (const auto& [name, method] : methods) {
      const Figures figures = Run(method, queries, off_m, off_deg);
      std::printf("%-11s %4.1f m %3.1f deg  %-20s %8.3f %8.3f %8.3f %8.3f %8.0f\n",
                  drives.name.c_str(), off_m, off_deg, name, Quantile(figures.times_ms, 0.5),
                  Quantile(figures.errors_m, 0.5), Quantile(figures.errors_m, 0.95),
                  Quantile(figures.errors_deg, 0.5),
                  100.0 * figures.success_count / static_cast<double>(queries.size()));
    }
  }
}

}  // namespace
}  // namespace dcloc::benchmarks

int main(int argc, char** argv) {
  using namespace dcloc::benchmarks;  // NOLINT(google-build-using-namespace)
  const bool smoke = IsSmokeRun(argc, argv);
  std::printf("%-11s %-14s %-20s %8s %8s %8s %8s %8s\n", "case", "start", "method", "p50 ms",
              "p50 m", "p95 m", "p50 deg", "success %");
  for (const char* name : {"ars408", "carla"}) {
    Compare(SimulatedCase(name, smoke ? 60.0 : 500.0), smoke ? 40 : 10, smoke ? 1 : 50);
  }
  return 0;
}
