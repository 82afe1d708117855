#pragma once

#include <string>
#include <vector>

#include "client/evaluation/gnuplot.h"
#include "client/evaluation/outcome.h"

namespace dcloc {

/// One evaluation of a drive, by the name that the legend gives it.
struct LabelledOutcome {
  std::string label;
  const DriveOutcome* outcome = nullptr;
};

/// A drive in the map it was localized in: landmarks, true and estimated tracks with the first
/// outcome's covariance ellipses, a close-up of its largest error, errors over time and their
/// distribution. `outcomes` (one or two) are of the same drive; tracks are lines where `is_track`,
/// points otherwise.
Picture DrawDrive(const std::vector<LabelledOutcome>& outcomes, bool is_track);

}  // namespace dcloc
