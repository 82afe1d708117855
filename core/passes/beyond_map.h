#pragma once

#include "core/map/radar_map.h"

namespace dcloc {

struct PlacedPass;

struct BeyondMapOptions {
  double reach_m = 20.0;       ///< from a keyframe: what is nearer was driven for the map
  double max_way_m = 500.0;    ///< from a scan that was tracked; odometry drifts
  int min_tracked_count = 50;  ///< scans of a pass that were tracked, by which the rest is placed
};

/// Has those scans of `pass` count, too, that were taken where the map was not driven, and places
/// them by odometry from those that were tracked. Scans that do not count, and may, have points;
/// of those that still do not count afterwards they are removed.
void PlaceBeyondMap(const RadarMap& map, const BeyondMapOptions& options, PlacedPass& pass);

}  // namespace dcloc
