#include "client/evaluation/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace dcloc {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double Mean(const std::vector<double>& values) {
  if (values.empty()) return kNan;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double Share(std::size_t count, std::size_t total) {
  return total == 0 ? kNan : static_cast<double>(count) / static_cast<double>(total);
}

ErrorSummary Summarize(const std::vector<double>& errors) {
  std::vector<double> squares(errors.size());
  std::ranges::transform(errors, squares.begin(), [](double error) { return error * error; });
  return {.mean = Mean(errors),
          .median = Quantile(errors, 0.5),
          .rms = std::sqrt(Mean(squares)),
          .p95 = Quantile(errors, 0.95),
          .max = Quantile(errors, 1.0)};
}

DurationSummary SummarizeDurations(const std::vector<double>& durations_ms) {
  return {.mean = Mean(durations_ms),
          .p50 = Quantile(durations_ms, 0.5),
          .p99 = Quantile(durations_ms, 0.99)};
}

/// What is counted and collected while going through the scans.
struct Tally {
  std::vector<double> rte_m, rre_deg, nees_per_dof, total_ms;
  std::array<std::vector<double>, kStageNames.size()> stage_ms;
  std::size_t successes = 0;
  std::size_t inside_95 = 0;
  std::size_t inside_999 = 0;

  void AddTimes(const ScanOutcome& scan) {
    total_ms.push_back(scan.total_ms);
    for (std::size_t i = 0; i < stage_ms.size(); ++i) {
      if (scan.stage_ms[i].has_value()) stage_ms[i].push_back(*scan.stage_ms[i]);
    }
  }

  void AddError(const ScanOutcome& scan) {
    const PoseError& error = scan.error;
    rte_m.push_back(error.translation_m);
    rre_deg.push_back(error.rotation_deg);
    if (IsSuccess(scan)) ++successes;
    if (error.dof == 0) return;
    nees_per_dof.push_back(error.nees / error.dof);
    if (error.nees <= ChiSquare95(error.dof)) ++inside_95;
    if (error.nees <= ChiSquare999(error.dof)) ++inside_999;
  }
};

}  // namespace

bool IsSuccess(const ScanOutcome& scan) {
  return scan.answered() && scan.error.translation_m < kSuccessTranslation_m &&
         scan.error.rotation_deg < kSuccessRotation_deg;
}

bool IsMisleading(const ScanOutcome& scan) {
  return scan.answer.state == LocalizationState::kTracking && scan.error.dof > 0 &&
         scan.error.nees > ChiSquare999(scan.error.dof) &&
         scan.error.translation_m > kSuccessTranslation_m;
}

double Quantile(std::vector<double> values, double quantile) {
  if (values.empty()) return kNan;
  std::ranges::sort(values);
  const double rank = quantile * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], rank - static_cast<double>(below));
}

Metrics ComputeMetrics(std::span<const DriveOutcome> drives) {
  Metrics metrics{};
  Tally tally;
  for (const DriveOutcome& drive : drives) {
    metrics.refused_count += drive.refused_count;
    for (const ScanOutcome& scan : drive.scans) {
      ++metrics.scan_count;
      ++metrics.state_counts.at(static_cast<std::size_t>(scan.answer.state));
      if (IsMisleading(scan)) ++metrics.misleading_count;
      tally.AddTimes(scan);
      if (scan.answered()) tally.AddError(scan);
    }
  }
  metrics.answered_count = tally.rte_m.size();
  metrics.rte_m = Summarize(tally.rte_m);
  metrics.rre_deg = Summarize(tally.rre_deg);
  metrics.success_rate = Share(tally.successes, metrics.answered_count);
  metrics.success_rate_all = Share(tally.successes, metrics.scan_count);
  metrics.anees = Mean(tally.nees_per_dof);
  metrics.coverage_95 = Share(tally.inside_95, tally.nees_per_dof.size());
  metrics.coverage_999 = Share(tally.inside_999, tally.nees_per_dof.size());
  metrics.total_ms = SummarizeDurations(tally.total_ms);
  for (std::size_t i = 0; i < tally.stage_ms.size(); ++i) {
    metrics.stage_ms[i] = SummarizeDurations(tally.stage_ms[i]);
  }
  return metrics;
}

}  // namespace dcloc
