#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "client/trajectory/trajectory.h"
#include "client/trajectory/trajectory_error.h"
#include "core/mapping/survey.h"

namespace dcloc::cli {

/// A surveyed drive's nodes beside the reference poses of the scans that they lie at. Only to judge
/// a survey: nothing here goes into one.
struct DriveTruth {
  std::vector<Pose2> T_truth_nodes;  ///< of each node of the track
};
DriveTruth TruthOf(std::span<const TrajectoryPose> reference, const DriveTrack& track);

/// How good a survey is by the reference poses.
struct SurveyJudgement {
  TrajectoryError trajectory;           ///< of all drives in the map, aligned together
  TrajectoryDrift drift;                ///< of each drive before loops, over 100 m
  TrajectoryError before_loops;         ///< of each drive aligned alone, before loops
  std::size_t loop_count = 0;           ///< accepted
  std::size_t wrong_loop_count = 0;     ///< of them: registered more than 1 m or 3 degrees off
  std::size_t wrong_refused_count = 0;  ///< of those left out
  Pose2 T_truth_map;                    ///< the alignment
};
SurveyJudgement Judge(const Survey& survey, std::span<const DriveTruth> truths);

}  // namespace dcloc::cli
