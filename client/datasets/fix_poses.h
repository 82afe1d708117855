#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/datasets/bag_contents.h"
#include "core/geometry/geodetic_anchor.h"

namespace dcloc {

/// The anchor that drives near `position` share: that position rounded to a quarter of a degree, at
/// height 0, x to the east. Drives on two sides of where it changes lie in two frames.
GeodeticAnchor SharedAnchor(const GeodeticPosition& position);

/// "its frame lies at 57.75, 12.00 degrees": of a drive whose poses were tied to the Earth.
std::string AnchorNote(const GeodeticAnchor& anchor);

/// Makes `references` of `fixes`: positions of a satellite receiver in the frame of SharedAnchor,
/// level, and looking along the path that they drive; where they stand, as before. What is used is
/// added to `notes`. InvalidArgument where fewer than two fixes lie a metre apart.
absl::Status AddPosesOfFixes(BagContents& contents, std::vector<std::string>& notes);

}  // namespace dcloc
