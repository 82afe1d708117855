#include "client/evaluation/paper/speed_difference.h"

#include <chrono>
#include <limits>
#include <vector>

namespace dcloc::paper {
namespace {

struct Moment {
  Stamp stamp;
  Eigen::Vector2d position_m;
  double speed_mps;
};

Eigen::Vector2d Position(const DriveScan& entry) {
  return entry.T_map_vehicle.translation_m.head<2>();
}

// Speeds over half a second around each scan: poses are finer in time than they are exact.
std::vector<Moment> Moments(const Drive& drive) {
  constexpr auto kHalfSpan = std::chrono::milliseconds(250);
  std::vector<Moment> moments;
  std::size_t first = 0;
  std::size_t last = 0;
  for (const DriveScan& entry : drive.scans) {
    const Stamp stamp = entry.scan.stamp;
    while (drive.scans[first].scan.stamp < stamp - kHalfSpan) ++first;
    while (last + 1 < drive.scans.size() && drive.scans[last + 1].scan.stamp <= stamp + kHalfSpan) {
      ++last;
    }
    const double span_s =
        std::chrono::duration<double>(drive.scans[last].scan.stamp - drive.scans[first].scan.stamp)
            .count();
    const double way_m = (Position(drive.scans[last]) - Position(drive.scans[first])).norm();
    moments.push_back({stamp, Position(entry), span_s > 0.0 ? way_m / span_s : 0.0});
  }
  return moments;
}

}  // namespace

SpeedDifferences::SpeedDifferences(const Drive& map, const Drive& live) {
  const std::vector<Moment> map_moments = Moments(map);
  for (const Moment& now : Moments(live)) {
    double nearest_m2 = std::numeric_limits<double>::infinity();
    for (const Moment& then : map_moments) {
      const double distance_m2 = (then.position_m - now.position_m).squaredNorm();
      if (distance_m2 >= nearest_m2) continue;
      nearest_m2 = distance_m2;
      differences_mps_[now.stamp] = now.speed_mps - then.speed_mps;
    }
  }
}

std::optional<double> SpeedDifferences::At(Stamp stamp) const {
  const auto found = differences_mps_.find(stamp);
  if (found == differences_mps_.end()) return std::nullopt;
  return found->second;
}

}  // namespace dcloc::paper
