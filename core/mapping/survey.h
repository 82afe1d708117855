#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/mapping/drive_track.h"
#include "core/mapping/loop_finder.h"
#include "core/mapping/pairwise_consistency.h"
#include "core/mapping/place_finder.h"
#include "core/mapping/survey_checkpoint.h"
#include "core/mapping/survey_graph_solver.h"

namespace dcloc {

struct SurveyOptions {
  LoopFinderOptions loops;
  PairwiseConsistencyOptions consistency;
  PlaceFinderOptions places;
  SurveyGraphSolverOptions solver;
  /// Loops are looked for again as long as it helps, with every node.
  int refine_rounds = 2;
  std::size_t coarse_stride = 3;         ///< step between the nodes that the first round uses
  double min_path_m = 20.0;              ///< a drive that moved less is left out
  std::size_t min_landmark_count = 200;  ///< likewise one that shows fewer landmarks
  /// Weight of an edge below which it counts as left out.
  double min_weight = 0.5;
  double fix_slack_m = 5.0;  ///< by which drives may be bent before fixes hold them
};
std::span<const OptionField<SurveyOptions>> FieldsOf(const SurveyOptions& options);
absl::Status Validate(const SurveyOptions& options);

/// A position fix of a drive, in the map frame.
struct SurveyFix {
  std::size_t drive = 0;
  Stamp stamp;
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();
  double sigma_m = 1.0;  ///< along each axis
};

/// What became of a drive.
struct SurveyedDrive {
  std::string name;
  bool is_in_map = false;
  std::string reason;                ///< why it is not, or what is doubtful; may be empty
  std::vector<Pose2> T_map_nodes;    ///< of the track's nodes; in its own frame if not in map
  std::vector<Pose2> T_start_nodes;  ///< by ego-motion and neighbours alone, from the first node
  std::size_t neighbour_count = 0;   ///< registrations within the drive
};

/// A registration that closes a loop or joins two drives.
struct SurveyLoop {
  std::size_t drive_from = 0, node_from = 0;
  std::size_t drive_to = 0, node_to = 0;
  Pose2 T_from_to;                ///< as registered
  double squared_distance = 0.0;  ///< Mahalanobis, from the solution
  bool is_accepted = false;
};

/// Where the drives went, in one frame: that of the fixes, or of the first node in the map.
struct Survey {
  std::vector<SurveyedDrive> drives;       ///< in the order of the tracks
  std::vector<SurveyLoop> loops;           ///< accepted and left out
  std::size_t unconfirmed_loop_count = 0;  ///< registrations that no others confirmed
  std::size_t fix_count = 0;
  std::size_t accepted_fix_count = 0;
};

/// Gets the stage and the share of it that is done; returning false ends the survey with Cancelled.
using SurveyProgress = std::function<bool(const char* stage, double share)>;

/// Places drives from their scans alone: no poses are given. Ego-motion and registrations of
/// neighbouring nodes give each drive's trajectory. Registrations of what was passed again, and
/// place search between drives, close loops. Those that others confirm enter a pose graph, which
/// leaves out what contradicts it. FailedPrecondition when no drive is left, and says why.
///
/// With `checkpoints` it keeps what each stage found there, and goes on from what it finds there:
/// the survey of the same drives and fixes, whose result is the same to the bit. Errors of the
/// store, and of `CheckpointFromBytes`.
absl::StatusOr<Survey> SurveyDrives(std::span<const DriveTrack> tracks,
                                    std::span<const SurveyFix> fixes, const SurveyOptions& options,
                                    const SurveyProgress& progress,
                                    SurveyCheckpointStore* checkpoints = nullptr);

}  // namespace dcloc
