#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// When the range rates of a radar are taken for shifted ones by its own scans.
struct RangeRateOffsetOptions {
  /// Scans that follow one another sooner share their errors.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(200);
  int ransac_iterations = 40;
  double inlier_gate_mps = 0.3;
  int min_inlier_count = 8;
  double min_inlier_fraction = 0.6;  ///< of all votes
  int min_direction_count = 6;  ///< tens of degrees that inliers lie in: no mover fills so many
  /// Votes of targets within ten degrees of one another, as a fraction of all.
  double max_direction_fraction = 1.0 / 24.0;
  double max_reading_sigma_mps = 0.5;  ///< a scan that tells less is no reading
  double reading_sigma_mps = 0.1;      ///< of a reading besides the targets' noise
  double forgetting_factor = 0.98;     ///< weight of older readings
  // Targets above the plane have smaller range rates. They are the nearer ones, at the edges of the
  // view, and so they look like an offset in proportion to the speed of approach: 0.006 to 0.026 of
  // it on recordings. What is expected, and its deviation.
  double height_fraction = 0.015;
  double height_sigma_fraction = 0.012;
  int min_reading_count = 6;
  double evident_sigmas = 5.0;
  double min_offset_mps = 0.25;  ///< a smaller one is none
  double min_change_mps = 0.1;   ///< an offset is changed by no less
  double outlier_mps = 0.5;      ///< a reading further from what is expected is of another offset
};
std::span<const OptionField<RangeRateOffsetOptions>> FieldsOf(
    const RangeRateOffsetOptions& options);
absl::Status Validate(const RangeRateOffsetOptions& options);

/// One target of a scan: range rate = row . (v_ahead, v_left, offset) + noise, in radar axes.
struct RangeRateOffsetTarget {
  Eigen::Vector3d row;
  double range_rate_mps;
  double sigma_mps;
  double azimuth_sigma_rad;  ///< an error of the azimuth turns the row
  int direction;             ///< in which ten degrees it is, see `DirectionOf`
  double vote = 1.0;         ///< what it counts for, less where many lie in one direction
};

/// What RangeRateOffsetOfScan needs only while it runs.
using RangeRateOffsetWorkspace = std::vector<RangeRateOffsetTarget>;

/// What one scan says of an offset of its range rates.
struct RangeRateOffsetReading {
  ScalarEstimate offset_mps;
  double approach_mps = 0.0;  ///< of what stands, on average; negative behind
};

/// The offset by one scan alone. What stands still has range rates of `-u . v + offset`, whatever
/// the motion v is and wherever the radar looks: targets all over its view tell v from an offset
/// (METHOD section 18). Nothing where too few agree, or they lie too close together. The same scan
/// and `seed` give the same answer.
std::optional<RangeRateOffsetReading> RangeRateOffsetOfScan(const Scan& scan,
                                                            const RadarModel& radar,
                                                            std::uint32_t seed,
                                                            const RangeRateOffsetOptions& options,
                                                            RangeRateOffsetWorkspace& workspace);

/// Learns which radars report range rates that are shifted by a constant, each by its own scans:
/// where all radars of a vehicle are, neither they nor the wheels say which of them is right.
class RangeRateOffsets {
 public:
  RangeRateOffsets(std::size_t radar_count, const RangeRateOffsetOptions& options)
      : options_(options), radars_(radar_count) {}

  /// By how much the range rates of radar `index` are too large; 0 where that is not evident.
  double offset_mps(std::size_t index) const { return radars_[index].applied_mps; }

  /// A scan of radar `index` as it was sent. Whether `offset_mps` has changed.
  bool OnScan(Stamp stamp, std::size_t index, const Scan& scan, const RadarModel& radar);

 private:
  struct Watched {
    std::optional<Stamp> last;
    // Of readings of offset + fraction * approach, without what is known before.
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    int reading_count = 0;
    Eigen::Vector2d state = Eigen::Vector2d::Zero();  // offset [m/s], fraction
    double offset_sigma_mps = 0.0;
    double applied_mps = 0.0;
  };
  void Add(const RangeRateOffsetReading& reading, Watched& watched) const;
  double EvidentOffset(const Watched& watched) const;

  RangeRateOffsetOptions options_;
  std::vector<Watched> radars_;
  RangeRateOffsetWorkspace workspace_;
};

}  // namespace dcloc
