#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/map/radar_map.h"
#include "core/mapping/loop_finder.h"
#include "core/mapping/pairwise_consistency.h"
#include "core/mapping/survey_graph.h"
#include "core/options/option_fields.h"

namespace dcloc {

struct PlaceFinderOptions {
  double query_spacing_m = 40.0;      ///< driven between the sub-maps that are searched for
  std::size_t submap_half_count = 2;  ///< nodes before and after that take part in a sub-map
  int search_point_count = 300;
  int candidate_count = 4;      ///< of each sub-map that are registered
  double guess_sigma_m = 0.45;  ///< of a place that the search finds
  double guess_sigma_rad = 0.02;
  RegistrationGate gate = {.min_inlier_count = 120, .min_overlap = 0.45};
  int min_agreeing_count = 3;  ///< sub-maps that must agree on how two drives lie to one another
  double min_agreeing_path_m = 60.0;  ///< the path that they span, at least
  PairwiseConsistencyOptions consistency = {.tolerance_m = 1.5, .tolerance_share = 0.02};
};
std::span<const OptionField<PlaceFinderOptions>> FieldsOf(const PlaceFinderOptions& options);
absl::Status Validate(const PlaceFinderOptions& options);

/// A map of the landmarks of a group of drives, as far as place search needs one: keyframe i is
/// `nodes[i]`.
absl::StatusOr<std::shared_ptr<const RadarMap>> MapOfNodes(const SurveyGraph& graph,
                                                           const std::vector<std::size_t>& nodes);

/// How a drive was looked for in the frame of others.
struct PlaceFinding {
  std::vector<SurveyEdge> loops;  ///< that agree; empty where the drive was not found
  int query_count = 0;            ///< sub-maps that were searched for
  int match_count = 0;            ///< registrations that passed the gate
};

/// Finds where a drive crosses ground that other drives show, of which nothing is known: its
/// sub-maps are searched for in the whole map of the others, and what is found is registered.
/// Sub-maps that agree decide, as soon as there are enough.
class PlaceFinder {
 public:
  PlaceFinder(const PlaceFinderOptions& options, const LoopFinderOptions& loops)
      : options_(options), loops_(loops) {}

  /// `drive` in the frame of the drives of `group` (its first drive, SurveyGraph::GroupOfDrives).
  /// `progress` gets the share of the drive searched and returns whether to go on.
  absl::StatusOr<PlaceFinding> Find(const SurveyGraph& graph, std::size_t drive, std::size_t group,
                                    const std::function<bool(double)>& progress);

 private:
  std::vector<SurveyEdge> Agreeing(const SurveyGraph& graph,
                                   const std::vector<SurveyEdge>& matches) const;

  PlaceFinderOptions options_;
  LoopFinder loops_;
};

}  // namespace dcloc
