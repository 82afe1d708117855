#pragma once

#include "client/evaluation/gnuplot.h"
#include "core/map/map_diff.h"

namespace dcloc {

/// Two maps in the old one's plane: what both have in grey, what came, went and moved in colours,
/// with counts.
Picture DrawMapDiff(const MapDiff& diff);

}  // namespace dcloc
