#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "client/datasets/drive.h"

namespace dcloc {

/// Kinds of disturbances of a drive's scans.
enum class DisturbanceKind {
  kOutliers,       ///< most targets are elsewhere: half of them as if standing still
  kDisplacedCopy,  ///< all targets as seen from a place aside, the same one throughout
  kEmptyScans,     ///< no target
  kGap,            ///< no scan
};

/// Where a drive is disturbed, and how.
struct DisturbancePlan {
  std::vector<DisturbanceKind> kinds;  ///< one episode after the other takes the next of them
  double interval_s = 10.0;            ///< between episodes on average, [5, 1000]
  int burst_scans = 10;                ///< of each radar in an episode that is no gap, [1, 1000]
  double outlier_share = 0.6;          ///< of a scan's targets, [0, 1]
  double gap_s = 2.0;                  ///< [0.1, 100]
  std::uint64_t seed = 1;
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const DisturbancePlan& plan);

/// A time span of a drive in which something was wrong: from the first moment to the last.
struct Episode {
  Stamp begin, end;
};

/// A disturbed drive.
struct DisturbedDrive {
  Drive drive;                    ///< reference poses stay true; scans of a gap are gone
  std::vector<bool> touched;      ///< one for each of `drive.scans`
  std::vector<Episode> episodes;  ///< in their order; they do not overlap
};

/// Disturbs `drive` at places that the plan's seed draws, the last early enough that some seconds
/// of the drive follow. The same drive and plan give the same result. InvalidArgument for an
/// invalid plan, and for a scan of a radar that the rig does not describe.
absl::StatusOr<DisturbedDrive> Disturb(const Drive& drive, const DisturbancePlan& plan);

}  // namespace dcloc
