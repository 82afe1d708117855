#include "client/datasets/check/scan_statistics.h"

#include <algorithm>
#include <chrono>
#include <limits>

namespace dcloc {
namespace {

ScanStatistics StatisticsOfRadar(const Drive& drive, const std::string& radar_id) {
  ScanStatistics statistics{.radar_id = radar_id};
  std::vector<double> intervals_s;
  auto least_rad = std::numeric_limits<float>::infinity();
  float greatest_rad = -least_rad;
  for (const DriveScan& entry : drive.scans) {
    const Scan& scan = entry.scan;
    if (scan.radar_id != radar_id) continue;
    if (statistics.scan_count++ == 0) {
      statistics.first = scan.stamp;
    } else {
      intervals_s.push_back(std::chrono::duration<double>(scan.stamp - statistics.last).count());
    }
    statistics.last = scan.stamp;
    statistics.target_count += scan.size();
    for (const float azimuth_rad : scan.azimuth_rad) {
      least_rad = std::min(least_rad, azimuth_rad);
      greatest_rad = std::max(greatest_rad, azimuth_rad);
    }
    statistics.empty_count += scan.size() == 0 ? 1U : 0U;
    statistics.velocity_count += scan.ego_velocity ? 1U : 0U;
  }
  if (statistics.target_count > 0) {
    statistics.azimuth_span_rad = double{greatest_rad} - double{least_rad};
  }
  if (intervals_s.empty()) return statistics;
  statistics.longest_gap_s = std::ranges::max(intervals_s);
  const auto middle = intervals_s.begin() + static_cast<std::ptrdiff_t>(intervals_s.size() / 2);
  std::ranges::nth_element(intervals_s, middle);
  statistics.median_interval_s = *middle;
  return statistics;
}

}  // namespace

std::vector<ScanStatistics> ScanStatisticsOf(const Drive& drive) {
  std::vector<ScanStatistics> statistics;
  statistics.reserve(drive.rig.radars.size());
  for (const RadarModel& radar : drive.rig.radars) {
    statistics.push_back(StatisticsOfRadar(drive, radar.id));
  }
  return statistics;
}

}  // namespace dcloc
