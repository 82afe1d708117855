#include "core/update/witness.h"

#include <algorithm>
#include <chrono>

namespace dcloc {

Stamp FirstGoodStamp(const PlacedPass& pass) {
  return std::ranges::find(pass.scans, true, &PlacedScan::is_good)->stamp;
}

Witness WitnessOf(const PlacedPass& pass) {
  const auto since = FirstGoodStamp(pass).time_since_epoch();
  return {pass.vehicle, std::chrono::duration_cast<std::chrono::days>(since).count()};
}

}  // namespace dcloc
