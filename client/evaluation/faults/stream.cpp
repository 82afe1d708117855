#include "client/evaluation/faults/stream.h"

#include <algorithm>
#include <utility>

namespace dcloc::faults {
namespace {

constexpr float kLeastRange_m = 0.2F;

void ReverseScan(double beta_s, Scan& scan) {
  for (std::size_t row = 0; row < scan.size(); ++row) {
    const double range_m = static_cast<double>(scan.range_m[row]) -
                           2.0 * beta_s * static_cast<double>(scan.range_rate_mps[row]);
    scan.range_m[row] = std::max(kLeastRange_m, static_cast<float>(range_m));
    scan.range_rate_mps[row] = -scan.range_rate_mps[row];
  }
  if (!scan.ego_velocity) return;
  scan.ego_velocity->linear_mps *= -1.0;
  scan.ego_velocity->angular_radps *= -1.0;
}

}  // namespace

std::chrono::nanoseconds Duration(double seconds) {
  return std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

Stream StreamOf(const Drive& drive, const InitialPose& prior) {
  Stream stream{.name = drive.name, .map = nullptr, .rig = drive.rig, .prior = prior, .scans = {}};
  stream.scans.reserve(drive.scans.size());
  for (const auto& [scan, T_map_vehicle] : drive.scans) {
    stream.scans.push_back({scan, scan.stamp, scan.stamp, T_map_vehicle});
  }
  return stream;
}

void OrderByArrival(Stream& stream) {
  std::ranges::stable_sort(stream.scans, {}, &StreamScan::arrived);
}

Drive Reversed(const Drive& drive) {
  Drive reversed = drive;
  if (drive.scans.empty()) return reversed;
  const Stamp first = drive.scans.front().scan.stamp;
  const Stamp last = drive.scans.back().scan.stamp;
  std::ranges::reverse(reversed.scans);
  for (DriveScan& entry : reversed.scans) {
    entry.scan.stamp = first + (last - entry.scan.stamp);
    ReverseScan(drive.rig.Find(entry.scan.radar_id)->beta_s, entry.scan);
  }
  return reversed;
}

}  // namespace dcloc::faults
