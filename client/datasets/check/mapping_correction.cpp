#include "client/datasets/check/mapping_correction.h"

#include <algorithm>

namespace dcloc {

BagMapping CorrectedMapping(BagMapping mapping, std::span<const RangeRateCheck> checks) {
  using enum RangeRateMeaning;
  for (const RangeRateCheck& check : checks) {
    const auto radar = std::ranges::find(mapping.radars, check.radar_id, &RadarMapping::id);
    if (radar == mapping.radars.end()) continue;
    // The drive was read by the mapping: what is found is beside what it says.
    const bool is_turned = check.meaning == kTowards || check.meaning == kTowardsMirrored;
    const bool is_mirrored = check.meaning == kAwayMirrored || check.meaning == kTowardsMirrored;
    if (is_turned) radar->range_rate_is_towards = !radar->range_rate_is_towards;
    if (is_mirrored) radar->azimuth_is_clockwise = !radar->azimuth_is_clockwise;
    if (check.meaning == kCompensated) radar->range_rate_is_compensated = true;
  }
  return mapping;
}

}  // namespace dcloc
