#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "client/evaluation/outcome.h"

namespace dcloc::paper {

/// Of outcomes of the same drive by several methods, the scans at which every one of them succeeded
/// (the paper's selection): the same outcomes with those scans alone.
std::vector<DriveOutcome> CommonSuccesses(std::span<const DriveOutcome* const> outcomes);

inline constexpr double kCmPerM = 100.0;

/// How the translation error grows with the absolute speed difference: least squares over the
/// successful answers.
struct Slope {
  double m_per_mps = 0.0;  ///< NaN where it is not determined, as the bounds are
  double low = 0.0;        ///< of the 95 % interval
  double high = 0.0;
  std::size_t answer_count = 0;
};

/// Errors of one drive within seconds of one another are not independent: the interval counts each
/// drive's segments of five seconds as one draw (cluster-robust variance).
Slope ErrorSlope(std::span<const DriveOutcome> outcomes);

/// The successful answers of one range of absolute speed differences.
struct SpeedBin {
  double begin_mps = 0.0;
  double end_mps = 0.0;
  std::size_t count = 0;
  double rte_mean_m = 0.0, rte_median_m = 0.0;
  double rre_mean_deg = 0.0, rre_median_deg = 0.0;
};

/// Bins of 2 m/s, without those that hold fewer than `min_count` answers.
std::vector<SpeedBin> ErrorsBySpeedDifference(std::span<const DriveOutcome> outcomes,
                                              std::size_t min_count = 5);

}  // namespace dcloc::paper
