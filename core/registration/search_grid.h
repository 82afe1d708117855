#pragma once

#include <algorithm>

namespace dcloc {

/// What correlative searches share: a grid of positions and headings over a likelihood field.

/// A peak of the score is some four cells wide, as the field is blurred and points err: poses
/// nearer to one another than this are of one peak.
inline constexpr double kPeakWidth_cells = 4.0;

/// The step between headings: half of the points, those within `median_range_m`, move by at most
/// two cells, which is half of a peak. Near points move too little for a finer step.
inline double HeadingStep_rad(double cell_m, double median_range_m) {
  constexpr double kMinLever_m = 10.0;
  return 2.0 * cell_m / std::max(kMinLever_m, median_range_m);
}

}  // namespace dcloc
