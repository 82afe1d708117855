#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "client/evaluation/outcome.h"

namespace dcloc {

/// Of a set of errors; NaN where the set is empty.
struct ErrorSummary {
  double mean, median, rms, p95, max;
};

/// Of a set of durations; NaN where the set is empty.
struct DurationSummary {
  double mean, p50, p99;
};

/// The metrics of METHOD section 8. Errors, success, ANEES and coverage are over the scans that
/// were answered with a pose in the map; the others are counted.
struct Metrics {
  ErrorSummary rte_m;
  ErrorSummary rre_deg;
  double success_rate = 0.0;      ///< RTE < 2 m and RRE < 5 degrees, of the answered scans
  double success_rate_all = 0.0;  ///< the same, where a scan without an answer is a failure
  double anees = 0.0;             ///< mean of the NEES over its degrees of freedom; 1 is ideal
  double coverage_95 = 0.0;       ///< share of truths inside of the 95 % ellipsoid
  double coverage_999 = 0.0;
  std::size_t misleading_count = 0;  ///< tracking, > 2 m off and outside of the 99.9 % ellipsoid
  std::size_t scan_count = 0;        ///< that the localizer took
  std::size_t answered_count = 0;
  std::size_t refused_count = 0;
  std::array<std::size_t, 4> state_counts{};  ///< by LocalizationState
  std::array<DurationSummary, kStageNames.size()> stage_ms{};
  DurationSummary total_ms{};
};

inline constexpr double kSuccessTranslation_m = 2.0;
inline constexpr double kSuccessRotation_deg = 5.0;

/// Answered with a pose that is right by the paper's measure.
bool IsSuccess(const ScanOutcome& scan);

/// Called tracking, but more than 2 m off and outside of the 99.9 % ellipsoid.
bool IsMisleading(const ScanOutcome& scan);

/// Over all scans of all `drives`.
Metrics ComputeMetrics(std::span<const DriveOutcome> drives);

/// The value below which the share `quantile` of `values` lies, linear between ranks; NaN for none.
double Quantile(std::vector<double> values, double quantile);

}  // namespace dcloc
