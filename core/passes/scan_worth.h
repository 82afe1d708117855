#pragma once

#include <chrono>
#include <cstddef>
#include <optional>

#include "core/localizer/localizer.h"
#include "core/odometry/source_fault.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// Whether a scan of a drive says something of a map, and why not.
enum class ScanWorth {
  kGood,       ///< tracked for a while, certain, with sound sources
  kUntracked,  ///< without a tracked pose, or soon after there was none
  kUnsound,    ///< while a source was set aside
  kUnsure,     ///< its pose is too uncertain, or rests on few landmarks
};

struct ScanWorthOptions {
  std::chrono::nanoseconds settle = std::chrono::seconds(1);  ///< after tracking began
  double max_sigma_m = 0.3;                                   ///< of a pose that counts
  int min_inlier_count = 20;  ///< of a pose that counts: no landmark then bears much of it
};

/// Judges the scans of one drive by their answers, in the order of their stamps.
class ScanJudge {
 public:
  explicit ScanJudge(const ScanWorthOptions& options) : options_(options) {}

  /// `radar` is the scan's, by its number in the rig.
  ScanWorth Judge(const Localization& answer, std::size_t radar, Stamp stamp);

  /// Of the source that was set aside last.
  SourceFault fault() const { return fault_; }

 private:
  ScanWorthOptions options_;
  std::optional<Stamp> tracking_since_;
  SourceFault fault_ = SourceFault::kNone;
};

/// Of the horizontal position, the larger axis.
double HorizontalSigma_m(const Matrix6d& covariance);

}  // namespace dcloc
