#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/map/landmark_fusion.h"
#include "core/passes/center_matching.h"
#include "core/passes/placed_pass.h"
#include "core/update/base_landmarks.h"
#include "core/update/detection_model.h"
#include "core/update/false_hits.h"
#include "core/update/updated_keyframes.h"

namespace dcloc {

/// The places that an update decides about, and what each pass saw there. First come the base map's
/// landmarks, then the others, which passes see: in the base map's streets, in streets that join,
/// and last what lies where the base map has a landmark.
struct SeenPlaces {
  std::vector<LandmarkPosition> positions;  ///< of all places
  std::size_t known_count = 0;              ///< of the base map
  std::size_t found_in_base_count = 0;      ///< others that it has not, in its streets
  std::size_t found_count = 0;              ///< these, and those in streets that join

  std::vector<Landmark> others;
  std::vector<std::uint32_t> known_of_other;  ///< the base map's landmark there, or `kNoCenter`

  std::vector<PassSightings> sightings;              ///< by pass
  std::vector<std::vector<double>> position_ratios;  ///< equation 62, by pass and place
  FalseHits false_hits;

  /// Where the first `count` places lie, relative to the origin of the map.
  std::vector<Eigen::Vector2d> FirstPlaces_m(std::size_t count) const;
};

struct SeenPlacesOptions {
  CenterMatchingOptions matching;
  int min_center_scans = 2;  ///< of a pass that saw something at a place
};

/// What `passes`, which are aligned with the map at `origin_m`, see of its landmarks and besides.
SeenPlaces FindSeenPlaces(const BaseLandmarks& base, const UpdatedKeyframes& keyframes,
                          std::span<const PlacedPass* const> passes,
                          const Eigen::Vector3d& origin_m, const SeenPlacesOptions& options);

}  // namespace dcloc
