#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/mapping/drive_track.h"
#include "core/mapping/survey_graph_solver.h"

namespace dcloc {

/// How far a survey has come: what it goes on from after it was stopped.
struct SurveyCheckpoint {
  std::uint32_t finished_stage_count = 0;
  std::vector<Pose2> T_map_nodes;    ///< of all drives' nodes in one row, as in `SurveyGraph`
  std::vector<Pose2> T_start_nodes;  ///< by ego-motion and neighbours alone
  std::vector<SurveyEdge> neighbours;
  std::vector<SurveyEdge> loops;
  std::vector<SurveyEdge> refused_loops;
  std::vector<NodeFix> fixes;
  std::uint64_t unconfirmed_count = 0;
  std::uint64_t accepted_fix_count = 0;
  std::vector<std::string> findings;  ///< of each drive that could not be joined; may be empty
};

/// Where a survey keeps its checkpoint, one at a time.
class SurveyCheckpointStore {
 public:
  virtual ~SurveyCheckpointStore() = default;
  /// What errors call it.
  virtual const std::string& name() const = 0;
  /// The last one's bytes; none where there is none.
  virtual absl::StatusOr<std::vector<std::byte>> Read() = 0;
  virtual absl::Status Write(std::span<const std::byte> bytes) = 0;
};

/// A number that tells the input of one survey from that of another.
std::uint32_t InputOf(std::span<const DriveTrack* const> tracks, std::span<const NodeFix> fixes);

/// A checkpoint of the survey of `input` as bytes: little-endian, exact, with a checksum.
std::vector<std::byte> ToBytes(const SurveyCheckpoint& checkpoint, std::uint32_t input);

/// DataLoss for bytes that are no checkpoint of `node_count` nodes and `drive_count` drives;
/// FailedPrecondition for one of another survey.
absl::StatusOr<SurveyCheckpoint> CheckpointFromBytes(std::span<const std::byte> bytes,
                                                     std::uint32_t input, std::size_t node_count,
                                                     std::size_t drive_count);

}  // namespace dcloc
