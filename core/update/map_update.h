#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/map/editable_map.h"
#include "core/passes/pass_alignment.h"
#include "core/passes/placed_pass.h"
#include "core/update/landmark_history.h"
#include "core/update/new_streets.h"
#include "core/update/presence.h"
#include "core/update/seen_places.h"

namespace dcloc {

struct MapUpdateOptions {
  SeenPlacesOptions places;
  PassAlignmentOptions alignment;
  NewStreetOptions new_streets;
  PresenceModel presence;       ///< to begin with; shares and shapes are learned from the passes
  double base_age_days = 30.0;  ///< of the base map at the first pass
  double min_keep_probability = 0.5;  ///< probability of a landmark that stays in the map
  double min_add_probability = 0.5;   ///< probability of one that comes into it
  int min_witnesses = 2;              ///< vehicles or days, for any change
};

/// A map and what became of each of its landmarks.
struct MapUpdate {
  EditableMap map;                     ///< the new version
  std::vector<LandmarkHistory> known;  ///< of the base map's landmarks, in its order
  std::vector<LandmarkHistory> found;  ///< others
  std::size_t refined_count = 0;       ///< landmarks of `map` that passes and the base map share
  NewStreets new_streets;              ///< their keyframes come after the base map's in `map`
  std::vector<std::size_t> order;      ///< of the passes, by their stamps
  PresenceModel presence;              ///< as learned
};

/// Updates `base` with passes that were placed in it. Their poses are refined first, with the map
/// and one another. What went goes, what came and stays comes, what is there one day and not the
/// next does not. What stays and the passes see is refined (equation 64); the rest keeps its bits.
/// Streets that passes drove beyond the map join it. No pass changes anything alone.
/// InvalidArgument where no pass has a scan that counts.
absl::StatusOr<MapUpdate> UpdateMap(const EditableMap& base, std::span<const PlacedPass> passes,
                                    const MapUpdateOptions& options = {});

}  // namespace dcloc
