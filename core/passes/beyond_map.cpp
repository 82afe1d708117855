#include "core/passes/beyond_map.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/passes/pass_track.h"
#include "core/passes/placed_pass.h"

namespace dcloc {
namespace {

/// How far from a scan that was tracked, and where by odometry from there.
struct Continued {
  double way_m = std::numeric_limits<double>::infinity();
  Pose3 T_map_vehicle;
};

/// Of each scan, from the nearest one along the way that was tracked, before or after it.
std::vector<Continued> ContinueByOdometry(const PlacedPass& pass) {
  const std::size_t count = pass.scans.size();
  std::vector<Continued> continued(count);
  const auto walk = [&](auto number_of) {
    const PlacedScan* tracked = nullptr;
    double way_m = 0.0;
    for (std::size_t n = 0; n < count; ++n) {
      const PlacedScan& scan = pass.scans[number_of(n)];
      if (n > 0) {
        way_m += (scan.T_start_vehicle.translation_m -
                  pass.scans[number_of(n - 1)].T_start_vehicle.translation_m)
                     .norm();
      }
      if (scan.is_good) {
        tracked = &scan;
        way_m = 0.0;
      }
      Continued& here = continued[number_of(n)];
      if (tracked == nullptr || way_m >= here.way_m) continue;
      here = {way_m, tracked->T_map_vehicle *
                         Embed(tracked->T_start_vehicle.Inverse() * scan.T_start_vehicle)};
    }
  };
  walk([](std::size_t n) { return n; });
  walk([count](std::size_t n) { return count - 1 - n; });
  return continued;
}

void Drop(PlacedScan& scan) {
  scan.is_good = false;
  scan.is_beyond_map = false;
  scan.points = {};
}

}  // namespace

void PlaceBeyondMap(const RadarMap& map, const BeyondMapOptions& options, PlacedPass& pass) {
  const bool is_tied = pass.GoodCount() >= static_cast<std::size_t>(options.min_tracked_count);
  const std::vector<Continued> continued = ContinueByOdometry(pass);
  for (std::size_t i = 0; i < pass.scans.size(); ++i) {
    PlacedScan& scan = pass.scans[i];
    if (scan.is_good) continue;
    if (!is_tied || scan.points.empty() || continued[i].way_m > options.max_way_m) {
      Drop(scan);
      continue;
    }
    scan.is_good = true;
    scan.is_beyond_map = true;
    scan.T_map_vehicle = continued[i].T_map_vehicle;
  }
  if (!is_tied) return;
  const PassTrack track(pass, {});
  for (std::size_t k = 0; k < track.scans().size(); ++k) {
    PlacedScan& scan = pass.scans[track.scans()[k]];
    if (!scan.is_beyond_map) continue;
    scan.T_map_vehicle = scan.T_map_vehicle *
                         Embed(Flatten(scan.T_map_vehicle).Inverse() * track.T_map_vehicles()[k]);
    const Eigen::Vector3d& p_map_m = scan.T_map_vehicle.translation_m;
    if (!map.KeyframesWithin(p_map_m, options.reach_m).empty())
      Drop(scan);  // lost on mapped ground
  }
}

}  // namespace dcloc
