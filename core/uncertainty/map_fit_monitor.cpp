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
      {"memory", &O::memory, 0, 1, "the newest scan alone counts"},
      {"contradiction_sigmas", &O::contradiction_sigmas, 0, 1e6, "the share alone decides"},
      {"contradiction_share", &O::contradiction_share, 0, 1, "the deviations alone decide"},
      {"min_sigma", &O::min_sigma, 1e-6, 1},
      {"decline_drift_sigmas", &O::decline_drift_sigmas, 0, 1e6, "each lesser fit counts"},
      {"decline_max_sigmas", &O::decline_max_sigmas, 1e-6, 1e6},
      {"decline_limit_sigmas", &O::decline_limit_sigmas, 0, 1e6, "a single fit decides"},
      {"max_prediction_sigma_m", &O::max_prediction_sigma_m, 0, 100,
       "predictions are tested as exact"},
  };
  return kFields;
}

absl::Status Validate(const MapFitOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

// METHOD eq 51.
ScanFit MapFitMonitor::Judge(std::size_t radar_index, std::size_t point_count, double fit) const {
  const Expected& expected = radars_[radar_index];
  if (expected.count < options_.min_scan_count ||
      point_count < static_cast<std::size_t>(options_.min_point_count)) {
    return ScanFit::kUnknown;
  }
  const double sigma = std::max(options_.min_sigma, std::sqrt(expected.variance));
  const double least = std::min(expected.mean - options_.contradiction_sigmas * sigma,
                                (1.0 - options_.contradiction_share) * expected.mean);
  return fit < least ? ScanFit::kContradicts : ScanFit::kAgrees;
}

// METHOD eq 58.
bool MapFitMonitor::HasDeclined(std::size_t radar_index, std::size_t point_count, double fit) {
  const Expected& expected = radars_[radar_index];
  if (expected.count < options_.min_scan_count ||
      point_count < static_cast<std::size_t>(options_.min_point_count)) {
    return false;
  }
  const double sigma = std::max(options_.min_sigma, std::sqrt(expected.variance));
  const double sigmas = std::min((expected.mean - fit) / sigma, options_.decline_max_sigmas);
  decline_sigmas_ = std::max(0.0, decline_sigmas_ + sigmas - options_.decline_drift_sigmas);
  if (decline_sigmas_ <= options_.decline_limit_sigmas) return false;
  decline_sigmas_ = 0.0;
  return true;
}

void MapFitMonitor::Learn(std::size_t radar_index, std::size_t point_count, double fit) {
  if (point_count < static_cast<std::size_t>(options_.min_point_count)) return;
  Expected& expected = radars_[radar_index];
  ++expected.count;
  // At first the mean of all.
  const double share = std::max(1.0 - options_.memory, 1.0 / expected.count);
  const double apart = fit - expected.mean;
  expected.mean += share * apart;
  expected.variance = (1.0 - share) * (expected.variance + share * apart * apart);
}

void MapFitMonitor::Reset() {
  std::ranges::fill(radars_, Expected{});
  decline_sigmas_ = 0.0;
}

}  // namespace dcloc
