#pragma once

#include <optional>
#include <vector>

#include "core/map/radar_map.h"

namespace dcloc::server {

/// A rectangle, its sides along two axes.
struct Rectangle {
  double min_x = 0.0, max_x = 0.0, min_y = 0.0, max_y = 0.0;
};

/// Where street is mapped.
struct CoverageBox {
  Rectangle map_m;  ///< in the map frame
  /// x longitude, y latitude, where the map has an anchor. Across the date line longitudes go on
  /// above 180.
  std::optional<Rectangle> degrees;
};

/// Tight boxes around the keyframes of each square of 25 m and the ones that follow them on the
/// drive, up to 75 m wide, in a fixed order. Between keyframes at most 25 m apart there is no gap.
std::vector<CoverageBox> CoverageOf(const RadarMap& map);

/// Between a place and the nearest point of a rectangle, in the rectangle's unit; `x_scale` is what
/// a unit of x counts in units of y.
double DistanceTo(const Rectangle& rectangle, double x, double y, double x_scale = 1.0);

}  // namespace dcloc::server
