#pragma once

#include <vector>

#include "client/simulation/radar/echoes.h"

namespace dcloc::simulation {

/// Multipath of the strongest of `echoes`: mirror images in flat walls (behind the wall, with the
/// range rate of the image) and double bounces between vehicles (twice the range and the range
/// rate). Only those above the detection threshold.
std::vector<Echo> CollectGhosts(const std::vector<Echo>& echoes, const Occlusion& occlusion,
                                const RadarView& view, const RadarProfile& profile);

}  // namespace dcloc::simulation
