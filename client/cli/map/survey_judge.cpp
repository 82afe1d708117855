#include "client/cli/map/survey_judge.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/degrees.h"

namespace dcloc::cli {
namespace {

constexpr double kWrong_m = 1.0;
constexpr double kWrong_rad = 3.0 * kRadPerDeg;
constexpr double kDriftStretch_m = 100.0;

std::vector<TrajectoryPair> Pair(std::span<const Pose2> found, std::span<const Pose2> truth) {
  std::vector<TrajectoryPair> pairs;
  for (std::size_t i = 0; i < found.size(); ++i) {
    pairs.push_back({Embed(found[i]), Embed(truth[i])});
  }
  return pairs;
}

bool IsWrong(const SurveyLoop& loop, std::span<const DriveTruth> truths) {
  const Pose2& from = truths[loop.drive_from].T_truth_nodes[loop.node_from];
  const Pose2& to = truths[loop.drive_to].T_truth_nodes[loop.node_to];
  const Pose2 off = (from.Inverse() * to).Inverse() * loop.T_from_to;
  return off.translation_m.norm() > kWrong_m || std::abs(WrapAngle(off.yaw_rad)) > kWrong_rad;
}

}  // namespace

DriveTruth TruthOf(std::span<const TrajectoryPose> reference, const DriveTrack& track) {
  DriveTruth truth;
  for (const SurveyNode& node : track.nodes) {
    const auto scan = std::ranges::lower_bound(reference, node.stamp, {}, &TrajectoryPose::stamp);
    truth.T_truth_nodes.push_back(Flatten(scan->T_map_vehicle));
  }
  return truth;
}

SurveyJudgement Judge(const Survey& survey, std::span<const DriveTruth> truths) {
  SurveyJudgement judgement;
  std::vector<TrajectoryPair> all;
  double drift_weight = 0.0;
  for (std::size_t i = 0; i < survey.drives.size(); ++i) {
    const SurveyedDrive& drive = survey.drives[i];
    if (!drive.is_in_map) continue;
    const auto pairs = Pair(drive.T_map_nodes, truths[i].T_truth_nodes);
    all.insert(all.end(), pairs.begin(), pairs.end());
    const auto start = Pair(drive.T_start_nodes, truths[i].T_truth_nodes);
    const TrajectoryDrift drift = DriftOver(start, kDriftStretch_m);
    const auto weight = static_cast<double>(drift.segment_count);
    judgement.drift.translation_percent += weight * drift.translation_percent;
    judgement.drift.rotation_deg_per_100m += weight * drift.rotation_deg_per_100m;
    judgement.drift.segment_count += drift.segment_count;
    drift_weight += weight;
    const TrajectoryError alone = ErrorOf(start, AlignTrajectory(start));
    judgement.before_loops.rmse_m = std::max(judgement.before_loops.rmse_m, alone.rmse_m);
    judgement.before_loops.max_m = std::max(judgement.before_loops.max_m, alone.max_m);
    judgement.before_loops.rmse_deg = std::max(judgement.before_loops.rmse_deg, alone.rmse_deg);
  }
  if (drift_weight > 0.0) {
    judgement.drift.translation_percent /= drift_weight;
    judgement.drift.rotation_deg_per_100m /= drift_weight;
  }
  judgement.T_truth_map = AlignTrajectory(all);
  judgement.trajectory = ErrorOf(all, judgement.T_truth_map);
  for (const SurveyLoop& loop : survey.loops) {
    const bool is_wrong = IsWrong(loop, truths);
    if (loop.is_accepted) {
      ++judgement.loop_count;
      judgement.wrong_loop_count += is_wrong ? 1 : 0;
    } else {
      judgement.wrong_refused_count += is_wrong ? 1 : 0;
    }
  }
  return judgement;
}

}  // namespace dcloc::cli
