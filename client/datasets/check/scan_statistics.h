#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "client/datasets/drive.h"

namespace dcloc {

/// What a drive holds of one radar.
struct ScanStatistics {
  std::string radar_id;
  std::size_t scan_count = 0;
  std::size_t target_count = 0;    ///< of all scans
  std::size_t empty_count = 0;     ///< scans without a target
  std::size_t velocity_count = 0;  ///< scans with a velocity of the vehicle
  Stamp first;
  Stamp last;
  double median_interval_s = 0.0;
  double longest_gap_s = 0.0;
  double azimuth_span_rad = 0.0;  ///< from the least to the greatest of all targets

  /// Scans a second; 0 for a single scan.
  double Rate_hz() const { return median_interval_s > 0.0 ? 1.0 / median_interval_s : 0.0; }
};

/// One a radar, in the rig's order; also of radars without scans.
std::vector<ScanStatistics> ScanStatisticsOf(const Drive& drive);

}  // namespace dcloc
