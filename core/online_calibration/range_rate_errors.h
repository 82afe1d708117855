#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// When a radar's range rates are taken for a multiple of the true ones.
struct RangeRateErrorOptions {
  /// Only where a smaller fraction of a scan's targets stands still is a scale looked for.
  double max_static_fraction = 0.85;
  /// By a scale so much more of the targets that tell a ratio agree with the motion.
  double min_gain_fraction = 0.2;
  double min_range_rate_mps = 1.0;  ///< targets that are predicted to have less tell no ratio
  // Targets agree with a scale that predicts their range rate to within the sum of these.
  double gate_mps = 0.3;               ///< the constant part
  double gate_fraction = 0.05;         ///< the part in proportion to the range rate
  int min_target_count = 10;           ///< that tell a ratio
  int min_direction_count = 6;         ///< tens of degrees that they lie in: no mover fills so many
  double min_agreeing_fraction = 0.6;  ///< of the targets that tell a ratio
  double min_change = 0.02;            ///< by a scale nearer to 1 targets stand still as they are
  double min_offset_mps = 0.1;         ///< and by a smaller offset
  double max_offset_mps = 5.0;         ///< a larger one is not looked for
  /// Beyond which there is no scale, and below whose inverse range rates can only be compensated.
  double max_factor = 3.0;
  double same_fraction = 0.05;  ///< ratios that differ by no more are one scale
  int min_scan_count = 3;       ///< in a row, that show a scale before it is supposed
  // Registrations confirm the motion that a scale was compared with. It is learned after as many
  // and as long.
  int min_registration_count = 5;
  std::chrono::nanoseconds confirmed_after = std::chrono::seconds(1);
  /// One that fewer registrations have confirmed since is forgotten with the pose.
  int kept_registration_count = 100;
};
std::span<const OptionField<RangeRateErrorOptions>> FieldsOf(const RangeRateErrorOptions& options);
absl::Status Validate(const RangeRateErrorOptions& options);

/// The scale of range rates from which the radar, or its driver, has taken the ego-motion: what
/// stands still has 0.
inline constexpr double kCompensatedScale = 0.0;

/// What a radar reports of a target's range rate: `scale` times it, plus `offset_mps`.
struct RangeRateError {
  double scale = 1.0;
  double offset_mps = 0.0;

  bool is_none() const { return scale == 1.0 && offset_mps == 0.0; }
  bool is_offset() const { return offset_mps != 0.0; }
  bool is_compensated() const { return scale == kCompensatedScale; }
};

/// Learns which radars report a multiple of the range rate, the negative one included, one that is
/// shifted, or compensated ones: a wrong unit, a wrong waveform, a wrong sign, another column
/// (METHOD section 18). Wheels and a radar that differ by a factor say nothing of which is right;
/// registrations do. An error is first supposed, so that the targets of the radar that agree with
/// one another are kept, and learned once registrations agree with the motion that it was compared
/// with.
class RangeRateErrors {
 public:
  RangeRateErrors(std::size_t radar_count, const RangeRateErrorOptions& options)
      : options_(options), radars_(radar_count) {}

  /// Of the range rates of radar `index`; none where nothing was learned.
  const RangeRateError& Learned(std::size_t index) const { return radars_[index].learned; }
  /// Of those that were corrected by `Learned`; none where nothing is supposed.
  const RangeRateError& Supposed(std::size_t index) const { return radars_[index].supposed; }
  /// Both together.
  RangeRateError Whole(std::size_t index) const { return Composed(radars_[index]); }
  /// Compensated range rates do not tell how the vehicle moves.
  bool TellsMotion(std::size_t index) const { return !Learned(index).is_compensated(); }

  /// By how much the motion in use and the one that range rates tell have come apart since no radar
  /// agrees with the one in use [m].
  double disputed_distance_m() const { return disputed_distance_m_; }

  /// A scan of radar `index` whose range rates were corrected by `Learned(index)`: `static_count`
  /// of its targets stand still if the vehicle moves by `velocity`.
  void OnScan(Stamp stamp, std::size_t index, const Scan& scan, std::size_t static_count,
              const RadarModel& radar, const EgoVelocity& velocity);

  /// A registration was accepted, at the newest scan, while the pose is confirmed. Whether
  /// `Learned` has changed.
  bool OnRegistered(Stamp stamp);

  /// From now on another offset than before is taken from the range rates of radar `index` before
  /// they are given here.
  void OnOffsetCorrected(std::size_t index);

  /// The pose was given up. Whether `Learned` has changed.
  bool OnLost();

 private:
  struct Radar {
    RangeRateError learned = {};
    RangeRateError supposed = {};
    RangeRateError first = {};
    int scan_count = 0;   // in a row with about the first one's error
    bool agrees = false;  // at its last scan, with the motion in use
    std::optional<Stamp> supposed_since;
    int registration_count = 0;  // since it was supposed; then since it was learned
  };

  struct Target {
    double predicted_mps;
    double range_rate_mps;
    int direction;
  };

  RangeRateError Composed(const Radar& radar) const;
  void AddDisputed(Stamp stamp, const RangeRateError& error, const EgoVelocity& velocity);
  bool IsSame(const RangeRateError& a, const RangeRateError& b) const;

  // The error that most targets agree on; nothing where there is none. Of a scale and an offset the
  // one that they agreed on before goes on.
  std::optional<RangeRateError> ErrorOf(const Scan& scan, const RadarModel& radar,
                                        const EgoVelocity& velocity, const Radar& watched);
  void TakeTargets(const Scan& scan, const RadarModel& radar, const EgoVelocity& velocity);
  std::optional<RangeRateError> MedianScale();
  std::optional<RangeRateError> MedianOffset();
  double MedianOfTargets(double (*value)(const Target&));
  // By how many gates the target's range rate differs from the one that it has by `error`.
  double InGates(const Target& target, const RangeRateError& error) const;
  double CountAgreeing(const RangeRateError& error) const;
  double MisfitOf(const RangeRateError& error) const;

  RangeRateErrorOptions options_;
  std::vector<Radar> radars_;
  double disputed_distance_m_ = 0.0;
  std::optional<Stamp> disputed_;  // when the last scan was that disputes the motion
  std::vector<Target> targets_;    // memory of ErrorOf
  std::vector<double> values_;
};

/// Adds to each range rate of `scan` what a static target has by `velocity`.
void AddEgoMotion(const RadarModel& radar, const EgoVelocity& velocity, Scan& scan);

/// Undoes an `error` of range rates that are not compensated.
void CorrectRangeRates(const RangeRateError& error, Scan& scan);

/// Undoes any `error`.
void CorrectRangeRates(const RangeRateError& error, const RadarModel& radar,
                       const EgoVelocity& velocity, Scan& scan);

}  // namespace dcloc
