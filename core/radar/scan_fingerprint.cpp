#include "core/radar/scan_fingerprint.h"

#include <bit>
#include <vector>

namespace dcloc {
namespace {

// Mixes as splitmix64 does.
std::uint64_t Mixed(std::uint64_t hash, std::uint64_t value) {
  hash += value + 0x9e3779b97f4a7c15U;
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9U;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebU;
  return hash ^ (hash >> 31);
}

std::uint64_t Mixed(std::uint64_t hash, const std::vector<float>& column) {
  hash = Mixed(hash, column.size());
  for (const float value : column) hash = Mixed(hash, std::bit_cast<std::uint32_t>(value));
  return hash;
}

}  // namespace

std::uint64_t FingerprintOfTargets(const Scan& scan) {
  std::uint64_t hash = 0;
  for (const std::vector<float>* column :
       {&scan.range_m, &scan.range_rate_mps, &scan.azimuth_rad, &scan.elevation_rad, &scan.rcs_dbsm,
        &scan.range_sigma_m, &scan.range_rate_sigma_mps, &scan.azimuth_sigma_rad,
        &scan.elevation_sigma_rad}) {
    hash = Mixed(hash, *column);
  }
  return hash;
}

std::uint64_t FingerprintOf(const Scan& scan) {
  std::uint64_t hash = Mixed(FingerprintOfTargets(scan),
                             static_cast<std::uint64_t>(scan.stamp.time_since_epoch().count()));
  for (const char letter : scan.radar_id) {
    hash = Mixed(hash, static_cast<std::uint64_t>(static_cast<unsigned char>(letter)));
  }
  for (const MotionTick& tick : scan.ticks) {
    hash = Mixed(hash, static_cast<std::uint64_t>(tick.after_scan.count()));
    hash = Mixed(hash, std::bit_cast<std::uint64_t>(tick.speed_mps));
    hash = Mixed(hash, std::bit_cast<std::uint64_t>(tick.yaw_rate_radps));
  }
  return hash;
}

}  // namespace dcloc
