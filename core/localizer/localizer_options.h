#pragma once

#include "absl/status/status.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// Every choice in one vehicle's pipeline. The defaults are what is evaluated and recommended.
struct LocalizerOptions {
  int scans_per_submap = 10;  ///< per radar, [1, 100]

  /// The paper's three switches (Table II).
  bool doppler_compensation = true;
  bool uncertainty = true;
  bool truncation = true;

  StaticPointsOptions static_points;
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const LocalizerOptions& options);

}  // namespace dcloc
