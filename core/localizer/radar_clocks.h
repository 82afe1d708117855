#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// When a radar's clock is another one than that of the others.
struct RadarClocksOptions {
  /// While all clocks agree, a scan lies at most this far behind one that arrived before it.
  std::chrono::nanoseconds max_behind = std::chrono::milliseconds(300);
  /// While all clocks agree, a scan lies at most this far ahead of one that arrives after it.
  std::chrono::nanoseconds max_ahead = std::chrono::milliseconds(300);
  /// A scan that lies further ahead of all others is not used until it is known why.
  std::chrono::nanoseconds max_lead = std::chrono::seconds(1);
  /// Scans in a row that must show an offset before it is corrected.
  int min_scans = 4;
  /// Standard deviation of an offset [s]. The order of arrival gives it to within the time between
  /// two scans of different radars.
  double offset_sigma_s = 0.05;
  // Within the bounds above, a radar that is ahead of half of the others, or behind, is suspected:
  // its clock is off, or scans come late. How they fit the map tells which.
  /// By so much it is ahead or behind at least.
  std::chrono::nanoseconds min_suspected = std::chrono::milliseconds(5);
  /// Weight of older differences of fits beside the newest one, [0, 1).
  double fit_forgetting_factor = 0.95;
  /// The clock is off, or is not, when the weighted sum of these differences says it by this.
  double deciding_fit = 0.8;
  /// Scans for which a clock is not suspected after it was found to be right.
  int rest_scans = 500;
};
std::span<const OptionField<RadarClocksOptions>> FieldsOf(const RadarClocksOptions& options);
absl::Status Validate(const RadarClocksOptions& options);

/// Brings the stamps of a rig's radars to one clock. Scans arrive about in the order in which they
/// were taken, so that the order of arrival shows by how much a radar's clock is off (METHOD eq
/// 53).
class RadarClocks {
 public:
  RadarClocks(std::size_t radar_count, const RadarClocksOptions& options)
      : options_(options), radars_(radar_count) {}

  /// When a scan of radar `index`, stamped `stamp` by the radar's own clock, was taken, by the
  /// clock of the rig. Nothing while that is not known. Scans are given in the order of arrival.
  std::optional<Stamp> Align(std::size_t index, Stamp stamp);

  /// The clock of radar `index` was set: it is ahead by `step` more than before.
  void OnStep(std::size_t index, std::chrono::nanoseconds step);

  /// A radar whose clock may be off: by the order of arrival it is `ahead` of half of the others,
  /// or behind them where that is negative. Nothing with fewer than three radars.
  struct Suspect {
    std::size_t index;
    std::chrono::nanoseconds ahead;
  };
  std::optional<Suspect> Suspected() const;

  /// While a radar is suspected: a scan of radar `index`, which was sent last, fits the map by
  /// `as_stamped` and, if radars were apart by what is suspected, by `moved`: that of the suspect
  /// at an earlier moment by what it is ahead, that of another at a later one. Returns whether the
  /// suspect's clock is off for sure.
  bool OnFits(const Suspect& suspect, std::size_t index, double as_stamped, double moved);

  /// By how much the clock of radar `index` is ahead of that of the rig.
  std::chrono::nanoseconds Offset(std::size_t index) const { return radars_[index].offset; }
  /// It was found to be so by an earlier localizer of the same vehicle. Before the first scan.
  void Restore(std::size_t index, std::chrono::nanoseconds offset) {
    radars_[index].offset = offset;
  }
  bool IsOff(std::size_t index) const { return Offset(index) != std::chrono::nanoseconds(0); }
  /// The same offset [s] with its variance; nothing for a clock that is not off.
  std::optional<ScalarEstimate> OffsetEstimate(std::size_t index) const;

 private:
  /// The time from another radar's newest scan to each of the last ones of this radar.
  using SinceOther = absl::InlinedVector<std::chrono::nanoseconds, 4>;
  struct Watched {
    std::chrono::nanoseconds offset{0};
    std::optional<Stamp> last;  // by the rig's clock
    bool has_jumped = false;    // ahead of all others, and not known why
    std::size_t arrival = 0;    // of the last scan, counted over all radars
    std::size_t arrival_before_last = 0;
    std::vector<SinceOther> since_others;  // by the index of the other radar
  };

  bool IsAlive(const Watched& other, const Watched& radar) const;
  void Compare(std::size_t index, Stamp stamp);
  /// By how much, at least, radar `a` lies behind `b` in each of the last comparisons.
  std::optional<std::chrono::nanoseconds> MinLag(std::size_t a, std::size_t b) const;
  /// The middle of what the order of arrival allows for by how much `a` is ahead of `b`.
  std::optional<std::chrono::nanoseconds> RelativeOffset(std::size_t a, std::size_t b) const;
  bool DiffersFromMost(std::size_t index) const;
  /// The median over the others.
  std::chrono::nanoseconds AheadOfMost(std::size_t index) const;
  void CorrectOffset(std::size_t index);
  void ResetComparisons(std::size_t index);
  bool HasJumped(std::size_t index, Stamp stamp) const;

  // What fits have said of a suspect, each the weighted sum of by how much better moved scans fit.
  struct Trial {
    std::size_t index = 0;
    double of_suspect = 0.0;
    double of_others = 0.0;  // for one scan of each of them
    int rest = 0;            // scans that are not asked
  };

  RadarClocksOptions options_;
  std::vector<Watched> radars_;
  std::size_t arrivals_ = 0;
  Trial trial_;
};

}  // namespace dcloc
