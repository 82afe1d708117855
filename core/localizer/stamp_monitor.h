#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// What the regularity of stamps is worth.
struct StampMonitorOptions {
  int min_interval_count = 8;  ///< intervals after which a radar's period is known
  /// Fraction of a stamp's deviation from the line of regular stamps by which it moves that line.
  double phase_gain = 0.15;
  /// Fraction of that deviation, per period passed, by which it changes the period.
  double period_gain = 0.005;
  /// Deviations up to this are usual, and no error of stamps.
  std::chrono::nanoseconds usual_jitter = std::chrono::milliseconds(6);
  /// Time constant with which the largest deviation fades: one of this age counts 1 / e. Shared
  /// stamps are forgotten after it.
  std::chrono::nanoseconds time_constant = std::chrono::milliseconds(2000);
  // A stamp this far from where it is expected is a suspected step: the clock may have been set, or
  // scans before it were lost.
  double min_step_fraction = 0.4;  ///< shorter steps are not suspected, in periods of the radar
  /// Nor are steps shorter than this.
  std::chrono::nanoseconds min_step = std::chrono::milliseconds(40);
  /// Longer steps are not suspected.
  std::chrono::nanoseconds max_step = std::chrono::milliseconds(1000);
  /// A radar with a larger fraction of irregular intervals is not suspected of a step, [0, 1].
  double max_irregular_fraction = 0.2;
  /// Weight of older intervals in that fraction, [0, 1).
  double irregular_forgetting_factor = 0.95;
  /// A step is decided when the sum of differences between fits with and without it reaches this.
  double deciding_fit = 0.15;
  double min_fit = 0.15;         ///< fit without the step that is needed to call the clock set
  int max_undecided_scans = 20;  ///< scans after which an undecided step is taken for none
};
std::span<const OptionField<StampMonitorOptions>> FieldsOf(const StampMonitorOptions& options);
absl::Status Validate(const StampMonitorOptions& options);

/// How far the stamp of a scan may be from when the scan was taken, beside that of the others.
struct StampError {
  double bound_s = 0.0;           ///< upper bound, by the stamps themselves
  double sigma_s = 0.0;           ///< standard deviation, likewise
  double undecided_step_s = 0.0;  ///< further error if its clock was set, which is not decided yet
};

/// Estimates from the stamps of each radar how exact they are. Radars scan in a period of their
/// own, so stamps that leave its line are rounded, jump, or come after scans that were lost (METHOD
/// eq 54). Stamps that radars share say only that the scans are of one cycle. Where several radars
/// leave their lines in one cycle, by different times, scans are missing, and no clock was set.
class StampMonitor {
 public:
  StampMonitor(std::size_t radar_count, const StampMonitorOptions& options)
      : options_(options), radars_(radar_count) {}

  /// A scan of radar `index`, stamped `stamp` by the radar's own clock. Scans are given in the
  /// order of arrival, none twice. Gives by how much the clock may have been set, while that is not
  /// decided: the scan was taken at its stamp, or earlier by that.
  std::optional<std::chrono::nanoseconds> OnStamp(std::size_t index, Stamp stamp);

  /// Of a step that `OnStamp` has given: how the scan fits the map at its stamp, and where the
  /// vehicle was without the step. Returns whether the clock was surely set.
  bool OnFits(std::size_t index, double as_stamped, double without_step);

  /// The scan that was given last, of radar `index`, was refused: it says nothing.
  void Withdraw(std::size_t index);

  /// Of the newest scan of radar `index`.
  StampError ErrorOf(std::size_t index) const;

 private:
  struct Watched {
    std::optional<Stamp> last;
    int interval_count = 0;
    double irregular_fraction = 0.0;
    double period_s = 0.0;
    Stamp phase{};                   // where the line has the last stamp
    std::optional<Stamp> left_line;  // the last stamp that is not where it was expected
    double left_by_s = 0.0;          // likewise
    double deviation_s = 0.0;        // the largest of late
    double square_s2 = 0.0;          // mean
    std::optional<std::chrono::nanoseconds> step;  // suspected
    double step_evidence = 0.0;
    int undecided_scans = 0;
  };

  bool IsRegular(const Watched& radar) const;
  bool DetectStep(Watched& radar, std::chrono::nanoseconds interval) const;
  void UpdatePeriod(Watched& radar, Stamp stamp) const;
  void NoteLeaving(Watched& radar, Stamp stamp, double by_s) const;
  bool LeftWithAnother(std::size_t index) const;
  void NoteShared(std::size_t index, Stamp stamp);

  // Stamps that radars have in common.
  struct Shared {
    std::optional<Stamp> last;
    double bound_s = 0.0;
  };

  StampMonitorOptions options_;
  std::vector<Watched> radars_;
  Shared shared_;
  Watched radar_before_;  // the newest scan
  Shared shared_before_;
};

}  // namespace dcloc
