#include "core/localizer/radar_monitor.h"

#include <algorithm>

#include "absl/container/inlined_vector.h"
#include "core/radar/radar_model.h"

namespace dcloc {
std::span<const OptionField<RadarMonitorOptions>> FieldsOf(const RadarMonitorOptions& /*options*/) {
  using O = RadarMonitorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"silent_intervals", &O::silent_intervals, 1, 1000},
      {"silent_after_ms", &O::silent_after, 1, 1e5},
      {"max_interval_ratio", &O::max_interval_ratio, 1, 1000},
      {"forgetting_factor", &O::forgetting_factor, 0, 0.999, "the newest scan counts alone"},
      {"min_target_count", &O::min_target_count, 1, 10'000},
      {"min_static_fraction", &O::min_static_fraction, 0, 1, "no Doppler fault is reported"},
      {"min_fit_fraction", &O::min_fit_fraction, 0, 1, "no radar is set aside"},
      {"min_fit_of_others", &O::min_fit_of_others, 1e-6, 1},
  };
  return kFields;
}

absl::Status Validate(const RadarMonitorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void RadarMonitor::OnScan(Stamp stamp, std::size_t index, std::size_t target_count,
                          std::size_t static_count) {
  Watched& radar = radars_[index];
  if (static_cast<int>(target_count) >= options_.min_target_count) {
    Average(static_cast<double>(static_count) / static_cast<double>(target_count),
            radar.static_fraction);
  }
  if (radar.last && stamp <= *radar.last) return;
  if (radar.last) {
    const double interval_s = SecondsOf(stamp - *radar.last);
    if (radar.usual_interval_s == 0.0) radar.usual_interval_s = interval_s;
    Average(std::min(interval_s, options_.max_interval_ratio * radar.usual_interval_s),
            radar.usual_interval_s);
  }
  radar.last = stamp;
}

void RadarMonitor::OnFit(std::size_t index, double fit) {
  std::optional<double>& mean = radars_[index].fit;
  if (!mean) mean = fit;
  Average(fit, *mean);
}

void RadarMonitor::ResetFits() {
  for (Watched& radar : radars_) radar.fit.reset();
}

bool RadarMonitor::FitsTheMap(std::size_t index) const {
  if (!radars_[index].fit) return true;
  absl::InlinedVector<double, kMaxRadars> others;
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i != index && radars_[i].fit) others.push_back(*radars_[i].fit);
  }
  if (others.size() < 2) return true;
  const auto middle = others.begin() + static_cast<std::ptrdiff_t>(others.size() / 2);
  std::nth_element(others.begin(), middle, others.end());
  return *middle < options_.min_fit_of_others ||
         *radars_[index].fit >= options_.min_fit_fraction * *middle;
}

bool RadarMonitor::IsSilent(const Watched& radar, Stamp stamp) const {
  if (!radar.last) return true;
  const double silence_s = SecondsOf(stamp - *radar.last);
  return silence_s > SecondsOf(options_.silent_after) &&
         silence_s > options_.silent_intervals * radar.usual_interval_s;
}

SourceFault RadarMonitor::FaultOf(std::size_t index, Stamp stamp) const {
  const Watched& radar = radars_[index];
  if (IsSilent(radar, stamp)) return SourceFault::kSilent;
  if (radar.repeats) return SourceFault::kFrozen;
  if (!FitsTheMap(index)) return SourceFault::kMap;
  if (radar.static_fraction < options_.min_static_fraction) return SourceFault::kDoppler;
  if (radar.clock_is_off) return SourceFault::kClock;
  return SourceFault::kNone;
}

}  // namespace dcloc
