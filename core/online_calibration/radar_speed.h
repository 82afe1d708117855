#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

struct RadarSpeedOptions {
  /// Of a larger scan every n-th target is used, so that no more are.
  int max_target_count = 60;
  /// Targets that look further off the direction of travel tell less of the speed than of errors
  /// of azimuth. The least cosine between the two.
  double min_cosine = 0.12;
  /// Residuals of this size weigh half: the scale of the Cauchy weights. The first iteration has
  /// four times of it, the second twice.
  double residual_scale_mps = 0.12;
  int iteration_count = 7;
  /// How fast the vehicle may slip sideways, beside errors of the mount's yaw.
  double lateral_sigma_mps = 0.25;
  /// The speed is as certain as by this many targets along the track that fit, at least.
  double min_information = 2.0;
  /// A speed further from the reported one is that of a mover.
  double max_difference_mps = 1.0;
};
std::span<const OptionField<RadarSpeedOptions>> FieldsOf(const RadarSpeedOptions& options);
absl::Status Validate(const RadarSpeedOptions& options);

/// The forward speed of the vehicle frame's origin by the range rates of one radar (METHOD eq 65),
/// which frees the sideways one. The yaw rate is that of `reported`, from whose speed the search
/// begins.
class RadarSpeed {
 public:
  explicit RadarSpeed(const RadarSpeedOptions& options) : options_(options) {}

  /// [m/s]; nothing where too few targets agree.
  std::optional<double> Of(const Scan& scan, const RadarModel& radar, const EgoVelocity& reported);

 private:
  struct Row {
    double ahead, left;      // of the line of sight, in vehicle axes
    double approaching_mps;  // along it, what a static target says
  };

  RadarSpeedOptions options_;
  std::vector<Row> rows_;  // memory of Of
};

}  // namespace dcloc
