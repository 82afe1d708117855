#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "client/datasets/fix_file.h"
#include "client/simulation/simulation.h"
#include "core/geometry/geodetic_anchor.h"

namespace dcloc {

/// A satellite receiver: white noise as it claims, and what it does not claim.
struct FixOptions {
  double rate_hz = 0.0;            ///< 0: there is none
  double sigma_m = 1.5;            ///< along each horizontal axis; the height's is twice that
  double heading_sigma_deg = 0.0;  ///< 0: it gives no heading
  double jumps_per_min = 0.0;      ///< multipath: the position is off by a constant for a while
  double jump_m = 10.0;            ///< mean size of a jump; half to one and a half times that
  double jump_s = 5.0;
  double outages_per_min = 0.0;
  double outage_s = 10.0;
};

/// InvalidArgument naming the field, its value and its bound; OK otherwise.
absl::Status Validate(const FixOptions& options);

/// The fixes of a pass, during its scans: positions on the Earth with an `anchor`, else in the map
/// frame. Depends on the arguments alone; jumps and outages are the same at any rate and sigma.
std::vector<StampedFix> SimulateFixes(const SimulatedPass& pass, int pass_index,
                                      const FixOptions& options, std::uint64_t seed,
                                      const std::optional<GeodeticAnchor>& anchor);

}  // namespace dcloc
