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

/// When a radar is told of, or set aside.
struct RadarMonitorOptions {
  /// Silent for so many of its usual intervals, and for so long.
  double silent_intervals = 4.0;
  std::chrono::nanoseconds silent_after = std::chrono::milliseconds(500);
  /// A longer interval counts as so many usual ones: lost scans do not make a radar a slow one.
  double max_interval_ratio = 2.0;
  /// The weight of what its scans said before beside the newest.
  double memory = 0.9;
  int min_target_count = 10;  ///< a scan of fewer says nothing of its Doppler
  /// Its range rates contradict the motion if a smaller fraction of its targets stands still.
  double min_static_fraction = 0.1;
  /// Its targets do not lie in the map if they fit it by less than this fraction of how those of
  /// the other radars do, which fit it by so much at least. It needs two others.
  double min_fit_fraction = 0.4;
  double min_fit_of_others = 0.15;
};
std::span<const OptionField<RadarMonitorOptions>> FieldsOf(const RadarMonitorOptions& options);
absl::Status Validate(const RadarMonitorOptions& options);

/// Watches the radars of one rig, and sets aside the one whose targets do not lie in the map where
/// those of the others do.
class RadarMonitor {
 public:
  RadarMonitor(std::size_t radar_count, const RadarMonitorOptions& options)
      : options_(options), radars_(radar_count) {}

  /// A scan of radar `index` at `stamp`: so many targets, of which so many stand still.
  void OnScan(Stamp stamp, std::size_t index, std::size_t target_count, std::size_t static_count);

  /// Whether its stamps are those of another clock than the other radars'.
  void OnClock(std::size_t index, bool is_off) { radars_[index].clock_is_off = is_off; }

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
    std::optional<double> fit;
  };
  void Average(double value, double& mean) const {
    mean = options_.memory * mean + (1.0 - options_.memory) * value;
  }
  bool IsSilent(const Watched& radar, Stamp stamp) const;

  RadarMonitorOptions options_;
  std::vector<Watched> radars_;
};

}  // namespace dcloc
