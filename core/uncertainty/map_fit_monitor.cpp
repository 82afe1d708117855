#include "core/uncertainty/map_fit_monitor.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<MapFitOptions>> FieldsOf(const MapFitOptions& /*options*/) {
  using O = MapFitOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_point_count", &O::min_point_count, 1, 100'000},
      {"max_point_count", &O::max_point_count, 10, 100'000},
      {"min_scan_count", &O::min_scan_count, 2, 100'000},
      {"forgetting_factor", &O::forgetting_factor, 0, 1, "the newest scan alone counts"},
      {"learning_delay", &O::learning_delay, 0, 100'000, "each scan is learned from at once"},
      {"contradiction_sigmas", &O::contradiction_sigmas, 0, 1e6, "the share alone decides"},
      {"contradiction_share", &O::contradiction_share, 0, 1, "the deviations alone decide"},
      {"min_sigma", &O::min_sigma, 1e-6, 1},
      {"max_prediction_sigma_m", &O::max_prediction_sigma_m, 0, 100,
       "predictions are tested as exact"},
  };
  return kFields;
}

absl::Status Validate(const MapFitOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("decline", Validate(options.decline)));
  return status;
}

bool MapFitMonitor::IsComparable(const ForgettingMean& expected, std::size_t point_count) const {
  return expected.count >= options_.min_scan_count &&
         point_count >= static_cast<std::size_t>(options_.min_point_count);
}

double MapFitMonitor::Sigma(const ForgettingMean& expected) const {
  return std::max(options_.min_sigma, std::sqrt(expected.variance));
}

// METHOD eq 51.
ScanFit MapFitMonitor::Judge(std::size_t radar_index, std::size_t point_count, double fit) const {
  const ForgettingMean& expected = radars_[radar_index];
  if (!IsComparable(expected, point_count)) return ScanFit::kUnknown;
  const double least = std::min(expected.mean - options_.contradiction_sigmas * Sigma(expected),
                                (1.0 - options_.contradiction_share) * expected.mean);
  return fit < least ? ScanFit::kContradicts : ScanFit::kAgrees;
}

// METHOD eq 59.
void MapFitMonitor::Follow(std::size_t radar_index, std::size_t point_count, double fit) {
  const ForgettingMean& expected = radars_[radar_index];
  if (!IsComparable(expected, point_count)) return;
  decline_.Add((expected.mean - fit) / Sigma(expected), options_.decline);
  if (decline_.is_exceeded()) unlearned_.clear();
}

FitTrend MapFitMonitor::Trend() const {
  if (decline_.is_exceeded()) return FitTrend::kDeclined;
  return decline_.has_eased(options_.decline) ? FitTrend::kUsual : FitTrend::kDeclining;
}

void MapFitMonitor::Learn(std::size_t radar_index, std::size_t point_count, double fit) {
  if (point_count < static_cast<std::size_t>(options_.min_point_count)) return;
  ForgettingMean& expected = radars_[radar_index];
  if (expected.count < options_.min_scan_count) {  // nothing is expected that it could decline from
    return expected.Add(fit, options_.forgetting_factor);
  }
  unlearned_.push_back({radar_index, fit});
  if (unlearned_.size() <= static_cast<std::size_t>(options_.learning_delay)) return;
  const Fit& oldest = unlearned_.front();
  radars_[oldest.radar_index].Add(oldest.value, options_.forgetting_factor);
  unlearned_.erase(unlearned_.begin());
}

void MapFitMonitor::Reset() {
  std::ranges::fill(radars_, ForgettingMean{});
  unlearned_.clear();
  decline_ = {};
}

}  // namespace dcloc
