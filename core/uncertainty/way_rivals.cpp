#include "core/uncertainty/way_rivals.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<WayRivalOptions>> FieldsOf(const WayRivalOptions& /*options*/) {
  using O = WayRivalOptions;
  static constexpr OptionField<O> kFields[] = {
      {"step_m", &O::step_m, 0.1, 100},
      {"min_way_m", &O::min_way_m, 0.1, 100},
      {"max_way_m", &O::max_way_m, 0, 100, "there are no rivals"},
      {"pose_sigma_m", &O::pose_sigma_m, 0, 100, "poses are compared as exact"},
      {"point_sigma", &O::point_sigma, 1e-6, 1},
      {"drift_sigmas", &O::drift_sigmas, 0, 1e6, "each scan that fits a rival better counts"},
      {"max_sigmas", &O::max_sigmas, 1e-6, 1e6},
      {"limit_sigmas", &O::limit_sigmas, 0, 1e6, "a single scan decides"},
      {"scan_count", &O::scan_count, 0, 1'000'000, "a confirmed pose has no rivals"},
  };
  return kFields;
}

absl::Status Validate(const WayRivalOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

WayRivals::WayRivals(const WayRivalOptions& options) : options_(options) {
  for (double way_m = options.min_way_m; way_m <= options.max_way_m; way_m += options.step_m) {
    ways_m_.push_back(way_m);
    ways_m_.push_back(-way_m);
  }
  sums_sigmas_.resize(ways_m_.size());
}

// METHOD eq 57.
void WayRivals::OnFits(std::size_t point_count, bool is_confirmed, double fit,
                       std::span<const double> rival_fits) {
  confirmed_count_ = is_confirmed ? confirmed_count_ + 1 : 0;
  const double sigma = options_.point_sigma / std::sqrt(static_cast<double>(point_count));
  for (std::size_t i = 0; i < sums_sigmas_.size(); ++i) {
    const double sigmas = std::min((rival_fits[i] - fit) / sigma, options_.max_sigmas);
    sums_sigmas_[i] = std::max(0.0, sums_sigmas_[i] + sigmas - options_.drift_sigmas);
  }
}

std::optional<double> WayRivals::Better() const {
  const auto most = std::ranges::max_element(sums_sigmas_);
  if (most == sums_sigmas_.end() || *most <= options_.limit_sigmas) return std::nullopt;
  return ways_m_[static_cast<std::size_t>(most - sums_sigmas_.begin())];
}

void WayRivals::Reset() {
  std::ranges::fill(sums_sigmas_, 0.0);
  confirmed_count_ = 0;
}

}  // namespace dcloc
