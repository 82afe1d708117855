#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace dcloc::server {

/// How often a vehicle was looked at, and how often it was TRACKING.
struct TrackingCount {
  int looks = 0;
  int tracking = 0;
};

/// Vehicles in one version of a map, by their ids.
using VersionTally = std::map<std::string, TrackingCount>;

struct TrialOptions {
  int min_looks = 60;       ///< at a vehicle, for it to count
  int min_vehicles = 5;     ///< in each version, to judge
  double min_sigmas = 3.0;  ///< of the rank sum
  /// By how much the mean share of looks that were TRACKING is smaller.
  double min_share_lost = 0.02;
};

/// Two versions of a map side by side.
struct Trial {
  std::size_t canary_vehicles = 0;  ///< that count
  std::size_t active_vehicles = 0;
  double canary_share = 0.0;  ///< TRACKING, in the mean over vehicles
  double active_share = 0.0;
  double sigmas = 0.0;  ///< by which the canary's vehicles rank below the others
  bool is_canary_worse = false;
};

/// Whether vehicles are TRACKING less in the canary than others in the active version: by the rank
/// sum of Wilcoxon, Mann and Whitney over vehicles, ties counted, and by a share that matters. A
/// vehicle counts once, however long it drives, as its looks depend on one another.
Trial CompareVersions(const VersionTally& canary, const VersionTally& active,
                      const TrialOptions& options);

}  // namespace dcloc::server
