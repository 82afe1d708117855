#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// When a scan measures its radar's mount, and what shows that the mount changed.
struct MountYawOptions {
  // A vehicle that drives straight moves as it looks.
  double min_speed_mps = 3.0;       ///< at lower speeds the mount is not measured
  double max_yaw_rate_radps = 0.1;  ///< nor in tighter curves
  /// Readings that follow one another sooner share their errors.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(150);
  /// A target is an inlier if, as seen from the turned mount, it stands still within this.
  double inlier_gate_mps = 0.3;
  int min_inlier_count = 8;           ///< inliers that a reading needs
  double min_inlier_fraction = 0.35;  ///< share of the targets that must be inliers, [0, 1]
  /// Directions, ten degrees wide, that the inliers lie in where the mount is not as expected: one
  /// mover fills fewer, and passes for a radar that looks to the side.
  int min_direction_count = 6;
  int max_target_count = 100;  ///< a fuller scan is thinned
  /// Standard deviation of a reading besides the targets' noise.
  double reading_sigma_rad = 0.4 * kRadPerDeg;
  double speed_sigma_fraction = 0.03;  ///< of the vehicle's speed, as it is known
  /// Mounts stay as they are, nearly.
  double drift_sigma_rad = 0.08 * kRadPerDeg;  ///< in the square root of a second
  // Outliers in a row that agree mean that the radar was knocked, or that its mount was described
  // wrongly.
  double outlier_sigmas = 4.0;  ///< deviations from the expected angle that make an outlier
  int knocked_readings = 4;     ///< outliers in a row that it takes
  double knocked_spread_rad = 1.5 * kRadPerDeg;  ///< the most that neighbouring ones may differ by
  /// An outlier that no other reading follows counts no longer than this.
  std::chrono::nanoseconds outlier_span = std::chrono::milliseconds(500);
};
std::span<const OptionField<MountYawOptions>> FieldsOf(const MountYawOptions& options);
absl::Status Validate(const MountYawOptions& options);

/// One target as the estimate of a mount sees it: seen under the angle d further to the left, it
/// has a range rate of -(along cos d + across sin d) if it stands still.
struct MountYawTarget {
  double along_mps;   ///< the radar's velocity along the line of sight
  double across_mps;  ///< and across it, to the left
  double range_rate_mps;
  double sigma_mps;
  double azimuth_sigma_rad;
  int direction;  ///< in which ten degrees around the vehicle it is, see `DirectionOf`
};

/// What MountYawOfScan needs only while it runs.
using MountYawWorkspace = std::vector<MountYawTarget>;

/// By how much one radar looks further to the left than its mount says, from its own range rates:
/// while the vehicle drives straight they show where, to the radar, ahead is (METHOD eq 55).
class MountYawEstimator {
 public:
  /// The mount is as described, within `described_sigma_rad`.
  MountYawEstimator(double described_sigma_rad, const MountYawOptions& options)
      : options_(options), error_{0.0, described_sigma_rad * described_sigma_rad} {}

  /// An earlier session found this. It counts as `reading_count` readings of now, and like them it
  /// is given up if the next ones contradict it.
  void Restore(const ScalarEstimate& error, int reading_count) {
    error_ = error;
    reading_count_ = reading_count;
  }

  /// A scan of `radar`, whose mount is the described one, at `stamp` of a vehicle that moves with
  /// `velocity`, whose yaw rate others than radars say. Returns whether it was a reading.
  bool OnScan(Stamp stamp, const Scan& scan, const RadarModel& radar, const EgoVelocity& velocity,
              MountYawWorkspace& workspace);

  /// The angle [rad] and its variance.
  const ScalarEstimate& error() const { return error_; }
  int reading_count() const { return reading_count_; }

  /// The last reading was far from what was expected: the next ones will show whether the radar was
  /// knocked.
  bool HasRecentOutliers(Stamp stamp) const {
    return !outliers_rad_.empty() && last_ && stamp - *last_ < options_.outlier_span;
  }

 private:
  void KalmanUpdate(const ScalarEstimate& reading);
  bool IsOfKnockedMount(const ScalarEstimate& reading);

  MountYawOptions options_;
  ScalarEstimate error_;
  std::optional<Stamp> last_;
  int reading_count_ = 0;
  std::vector<double> outliers_rad_;  // in a row
};

/// Which angles are tried: all within `around_rad` of `expected_rad`. The inliers of the best one
/// lie in so many directions at least.
struct MountYawTrial {
  double expected_rad = 0.0;
  double around_rad = 0.0;
  int min_direction_count = 0;
};

/// The angle by one scan alone, nothing if no angle explains enough of its range rates.
std::optional<ScalarEstimate> MountYawOfScan(const Scan& scan, const RadarModel& radar,
                                             const EgoVelocity& velocity,
                                             const MountYawTrial& trial,
                                             const MountYawOptions& options,
                                             MountYawWorkspace& workspace);

}  // namespace dcloc
