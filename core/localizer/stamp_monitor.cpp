#include "core/localizer/stamp_monitor.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

using std::chrono::nanoseconds;

nanoseconds NanosecondsIn(double seconds) {
  return std::chrono::round<nanoseconds>(std::chrono::duration<double>(seconds));
}

}  // namespace

std::span<const OptionField<StampMonitorOptions>> FieldsOf(const StampMonitorOptions& /*options*/) {
  using O = StampMonitorOptions;
  static constexpr OptionField<O> kFields[] = {
      {"min_interval_count", &O::min_interval_count, 2, 1000},
      {"phase_gain", &O::phase_gain, 1e-3, 1},
      {"period_gain", &O::period_gain, 1e-4, 1},
      {"usual_jitter_ms", &O::usual_jitter, 0, 1000, "every deviation counts"},
      {"time_constant_ms", &O::time_constant, 1, 1e5},
      {"min_step_fraction", &O::min_step_fraction, 0, 10, "the time alone decides"},
      {"min_step_ms", &O::min_step, 1, 1e4},
      {"max_step_ms", &O::max_step, 0, 1e5, "no step is suspected"},
      {"max_irregular_fraction", &O::max_irregular_fraction, 0, 1, "no step is suspected"},
      {"irregular_forgetting_factor", &O::irregular_forgetting_factor, 0, 0.999,
       "the newest interval counts alone"},
      {"deciding_fit", &O::deciding_fit, 1e-3, 100},
      {"min_fit", &O::min_fit, 0, 1, "any fit decides"},
      {"max_undecided_scans", &O::max_undecided_scans, 1, 1000},
  };
  return kFields;
}

absl::Status Validate(const StampMonitorOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::optional<nanoseconds> StampMonitor::OnStamp(std::size_t index, Stamp stamp) {
  Watched& radar = radars_[index];
  radar_before_ = radar;
  shared_before_ = shared_;
  NoteShared(index, stamp);
  if (!radar.last || DetectStep(radar, stamp - *radar.last)) {
    radar.phase = stamp;
  } else {
    UpdatePeriod(radar, stamp);
  }
  radar.last = stamp;
  // One that is shared leaves its radar's line by up to a cycle, and no clock was set.
  if (shared_.last || LeftWithAnother(index)) radar.step.reset();
  return radar.step;
}

void StampMonitor::NoteLeaving(Watched& radar, Stamp stamp, double by_s) const {
  const double usual_s =
      std::max(SecondsOf(options_.usual_jitter), 3.0 * std::sqrt(radar.square_s2));
  if (std::abs(by_s) <= usual_s) return;
  radar.left_line = stamp;
  radar.left_by_s = by_s;
}

// Clocks that are set together are set by the same time.
bool StampMonitor::LeftWithAnother(std::size_t index) const {
  const Watched& radar = radars_[index];
  if (!radar.left_line) return false;
  return std::ranges::any_of(radars_, [&](const Watched& other) {
    if (&other == &radar || !other.left_line) return false;
    const double apart_s = std::abs(SecondsOf(*other.left_line - *radar.left_line));
    return apart_s <= std::max(radar.period_s, other.period_s) + std::abs(radar.left_by_s) &&
           std::abs(other.left_by_s - radar.left_by_s) > SecondsOf(options_.usual_jitter);
  });
}

bool StampMonitor::IsRegular(const Watched& radar) const {
  return radar.interval_count >= options_.min_interval_count &&
         radar.irregular_fraction <= options_.max_irregular_fraction;
}

// Whether the stamps go on along another line. A step that is not decided lasts until they jump
// once more.
bool StampMonitor::DetectStep(Watched& radar, nanoseconds interval) const {
  if (radar.interval_count < options_.min_interval_count) return false;
  const nanoseconds jump = interval - NanosecondsIn(radar.period_s);
  const nanoseconds least =
      std::max(options_.min_step, NanosecondsIn(options_.min_step_fraction * radar.period_s));
  const bool jumped = std::chrono::abs(jump) >= least;
  const bool is_suspect = jumped && std::chrono::abs(jump) <= options_.max_step && IsRegular(radar);
  const double kept = options_.irregular_forgetting_factor;
  radar.irregular_fraction = kept * radar.irregular_fraction + (jumped ? 1.0 - kept : 0.0);
  if (jumped) {
    radar.step.reset();
    NoteLeaving(radar, *radar.last + interval, SecondsOf(jump));
  }
  if (!is_suspect) return false;
  radar.step = jump;
  radar.step_evidence = 0.0;
  radar.undecided_scans = 0;
  return true;
}

// METHOD eq 54. At first the period is the mean of the intervals.
void StampMonitor::UpdatePeriod(Watched& radar, Stamp stamp) const {
  const double interval_s = SecondsOf(stamp - *radar.last);
  if (radar.interval_count < options_.min_interval_count) {
    ++radar.interval_count;
    radar.period_s += (std::abs(interval_s) - radar.period_s) / radar.interval_count;
    radar.phase = stamp;
    return;
  }
  const double periods = radar.period_s > 0.0 ? std::round(interval_s / radar.period_s) : 0.0;
  const double deviation_s = SecondsOf(stamp - radar.phase) - periods * radar.period_s;
  NoteLeaving(radar, stamp, deviation_s);
  const double fading = std::exp(-std::abs(interval_s) / SecondsOf(options_.time_constant));
  radar.deviation_s = std::max(fading * radar.deviation_s, std::abs(deviation_s));
  radar.square_s2 = fading * radar.square_s2 + (1.0 - fading) * deviation_s * deviation_s;
  radar.phase = stamp - NanosecondsIn((1.0 - options_.phase_gain) * deviation_s);
  if (periods > 0.0) radar.period_s += options_.period_gain * deviation_s / periods;
}

void StampMonitor::NoteShared(std::size_t index, Stamp stamp) {
  for (std::size_t i = 0; i < radars_.size(); ++i) {
    if (i == index || radars_[i].last != stamp) continue;
    shared_ = {.last = stamp, .bound_s = std::max(radars_[i].period_s, radars_[index].period_s)};
  }
  if (shared_.last && std::chrono::abs(stamp - *shared_.last) > options_.time_constant) {
    shared_ = {};
  }
}

bool StampMonitor::OnFits(std::size_t index, double as_stamped, double without_step) {
  Watched& radar = radars_[index];
  radar.step_evidence += without_step - as_stamped;
  ++radar.undecided_scans;
  const bool was_set =
      radar.step_evidence >= options_.deciding_fit && without_step >= options_.min_fit;
  if (was_set || radar.step_evidence <= -options_.deciding_fit ||
      radar.undecided_scans >= options_.max_undecided_scans) {
    radar.step.reset();
  }
  return was_set;
}

void StampMonitor::Withdraw(std::size_t index) {
  radars_[index] = radar_before_;
  shared_ = shared_before_;
}

StampError StampMonitor::ErrorOf(std::size_t index) const {
  const Watched& radar = radars_[index];
  const double jitter_s = SecondsOf(options_.usual_jitter);
  StampError error;
  if (radar.deviation_s > jitter_s) {
    error.bound_s = radar.deviation_s;
    error.sigma_s = std::sqrt(radar.square_s2);
  }
  if (shared_.last) {
    error.bound_s += shared_.bound_s;
    error.sigma_s = std::hypot(error.sigma_s, shared_.bound_s / std::sqrt(12.0));
  }
  if (radar.step) error.undecided_step_s = std::abs(SecondsOf(*radar.step));
  return error;
}

}  // namespace dcloc
