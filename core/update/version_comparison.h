#pragma once

#include <vector>

#include "core/map/editable_map.h"
#include "core/update/version_score.h"

namespace dcloc {

/// The landmarks of two versions of a map, by what became of them.
struct VersionComparison {
  std::vector<PlacedLandmark> common;   ///< of the old version, which the new one has too
  std::vector<PlacedLandmark> removed;  ///< of the old version alone
  std::vector<PlacedLandmark> added;    ///< of the new version alone
};

/// A landmark of one version is in the other one too if that has a landmark within `same_m`: a
/// refined landmark is the same. The versions share a frame and a local origin.
VersionComparison CompareVersions(const EditableMap& old_version, const EditableMap& new_version,
                                  double same_m);

}  // namespace dcloc
