#pragma once

#include <chrono>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/odometry/two_sided_cusum.h"
#include "core/options/option_fields.h"
#include "core/radar/scan.h"

namespace dcloc {

/// When the wheels' scale is said to have changed at once.
struct WheelScaleMonitorOptions {
  TwoSidedCusumOptions change;
  /// Speeds are compared by their means over spans of this length.
  std::chrono::nanoseconds span = std::chrono::milliseconds(300);
  /// Readings further apart are of two spans.
  std::chrono::nanoseconds max_gap = std::chrono::milliseconds(500);
  int min_reading_count = 2;  ///< a span of fewer readings is not used
  /// Spans that are slower are not used: their ratio is mostly noise.
  double min_speed_mps = 3.0;
  // Standard deviations of the difference between the means of a span.
  double speed_sigma_mps = 0.05;        ///< of noise
  double reading_sigma_mps = 0.1;       ///< of noise, of a single reading
  double speed_sigma_fraction = 0.006;  ///< of an error in proportion to the speed
  double delay_sigma_s = 0.1;           ///< of a delay between the two, while the speed changes
  int usual_span_count = 100;           ///< spans that the usual ratio is the mean of
  int min_usual_span_count = 12;        ///< spans that it takes before changes are looked for
  double usual_sigmas = 3.0;  ///< spans that deviate by more are no part of the usual ratio
  /// A smaller change is left to registrations, which learn it by themselves.
  double min_change = 0.01;
  /// By more than this share the scale of wheels does not change: they slip.
  double max_change = 0.12;
  /// The deviation of a change is at least this fraction of it: the first span may be partly of
  /// before.
  double change_sigma_fraction = 0.25;
};
std::span<const OptionField<WheelScaleMonitorOptions>> FieldsOf(
    const WheelScaleMonitorOptions& options);
absl::Status Validate(const WheelScaleMonitorOptions& options);

/// The wheels' scale has changed.
struct WheelScaleChange {
  ScalarEstimate share;     ///< by which the scale is larger than it was
  double distance_m = 0.0;  ///< driven since, by wheels
};

/// Finds that the wheels' speed is suddenly another multiple of Doppler's: their scale has changed
/// by too little to be slip (METHOD eq 58). Their usual ratio does not matter for that. It tells
/// the scale itself, but no better than one span does: so much may both get wrong alike.
class WheelScaleMonitor {
 public:
  explicit WheelScaleMonitor(const WheelScaleMonitorOptions& options = {})
      : options_(options), change_(options.change) {}

  /// What both say at `stamp`, which is not before the last one; the wheels' speed as reported.
  /// Gives a change once it is found.
  std::optional<WheelScaleChange> OnSpeeds(Stamp stamp, double wheels_mps, double doppler_mps);

  /// What the wheels' speed is to be multiplied by to be Doppler's, with the variance that one span
  /// leaves: what both get wrong alike no number of spans averages out. Given once, when as many
  /// spans as it takes were compared, and once more after `TellScaleAgain`.
  std::optional<ScalarEstimate> TakeScale();
  void TellScaleAgain() { has_told_scale_ = false; }

  /// A share by which the scale may have changed: not enough to be called a change yet.
  std::optional<double> UnconfirmedChange() const;

  /// Whether the ratio of what both say at one moment is unusual, be it the wheels or Doppler,
  /// while the speed changes by `acceleration_mps2`.
  bool IsUnusual(double wheels_mps, double doppler_mps, double acceleration_mps2) const;

  /// Doppler is another multiple of the speed from now on: their usual ratio is learned anew.
  void ForgetRatio();

  /// One of the two is not sound: what it said of late is not compared.
  void OnUnsound();

 private:
  struct Span {
    Stamp begin{};
    Stamp end{};
    double first_wheels_mps = 0.0;
    double last_wheels_mps = 0.0;
    double wheels_sum_mps = 0.0;
    double doppler_sum_mps = 0.0;
    int count = 0;
  };

  std::optional<WheelScaleChange> OnSpan(const Span& span);
  double VarianceOf(const Span& span) const;
  void Learn(double ratio, double variance);
  void ForgetUnusual();

  WheelScaleMonitorOptions options_;
  std::optional<Span> span_;
  double usual_ratio_ = 1.0;
  double usual_variance_ = 0.0;  // of the ratio of one span, on average
  int usual_count_ = 0;
  bool has_told_scale_ = false;
  double unusual_distance_m_ = 0.0;  // since a span was last as usual
  TwoSidedCusum change_;
};

}  // namespace dcloc
