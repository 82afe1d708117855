#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/source_fault.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// When a radar is reported as faulty, or set aside.
struct RadarMonitorOptions {
  // A radar is silent when the time since its last scan exceeds both of these.
  double silent_intervals = 4.0;  ///< in units of its usual interval
  std::chrono::nanoseconds silent_after = std::chrono::milliseconds(500);  ///< at any interval
  /// Upper bound of an interval, in units of the usual one: lost scans do not make a radar slow.
  double max_interval_ratio = 2.0;
  double forgetting_factor = 0.9;  ///< weight of older scans in every mean, [0, 1)
  int min_target_count = 10;       ///< a scan of fewer says nothing of its Doppler
  /// Its range rates contradict the motion if a smaller fraction of its targets stands still.
  double min_static_fraction = 0.1;
  /// Its targets do not lie in the map if they fit it by less than this fraction of the median fit
  /// of the other radars. There must be two others.
  double min_fit_fraction = 0.4;
  double min_fit_of_others = 0.15;  ///< below this median fit of the others nothing is concluded
};
std::span<const OptionField<RadarMonitorOptions>> FieldsOf(const RadarMonitorOptions& options);
absl::Status Validate(const RadarMonitorOptions& options);

/// Watches the radars of one rig, and sets aside the one whose targets do not lie in the map where
/// those of the others do.
class RadarMonitor {
 public:
  RadarMonitor(std::size_t radar_count, const RadarMonitorOptions& options)
      : options_(options), radars_(radar_count) {}

  /// A scan of radar `index` at `stamp`: `target_count` targets, `static_count` of them standing
  /// still.
  void OnScan(Stamp stamp, std::size_t index, std::size_t target_count, std::size_t static_count);

  /// Reports whether the clock of radar `index` is off, so that its stamps had to be corrected.
  void ReportClockOffset(std::size_t index, bool is_off) { radars_[index].clock_is_off = is_off; }

  /// Reports whether radar `index` repeats what it sent before.
  void ReportRepeats(std::size_t index, bool repeats) { radars_[index].repeats = repeats; }

  /// How a scan of it fits the map, see MapFitMonitor.
  void OnFit(std::size_t index, double fit);

  /// The vehicle is elsewhere: how scans fit the map there is another matter.
  void ResetFits();

  bool FitsTheMap(std::size_t index) const;

  /// What is wrong with radar `index` at `stamp`.
  SourceFault FaultOf(std::size_t index, Stamp stamp) const;

 private:
  struct Watched {
    std::optional<Stamp> last;
    double usual_interval_s = 0.0;
    double static_fraction = 1.0;
    bool clock_is_off = false;
    bool repeats = false;
    std::optional<double> fit;
  };
  void Average(double value, double& mean) const {
    mean = options_.forgetting_factor * mean + (1.0 - options_.forgetting_factor) * value;
  }
  bool IsSilent(const Watched& radar, Stamp stamp) const;

  RadarMonitorOptions options_;
  std::vector<Watched> radars_;
};

}  // namespace dcloc
