#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/scalar_estimate.h"
#include "core/online_calibration/radar_speed.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// How the delays of radars are looked for, and how well they are known (METHOD eq 65 to 67).
struct RadarDelayOptions {
  RadarSpeedOptions speed;
  /// Delays that are compared lie this far apart, kRadarDelaySteps to either side.
  std::chrono::nanoseconds step = std::chrono::milliseconds(40);
  /// Reported velocities that lie further apart are not interpolated.
  std::chrono::nanoseconds max_gap = std::chrono::milliseconds(300);
  /// Moments of one radar that follow one another sooner share their noise.
  std::chrono::nanoseconds interval = std::chrono::milliseconds(65);
  /// The time constant with which older moments lose weight. Delays are a constant of the hardware.
  std::chrono::nanoseconds time_constant = std::chrono::minutes(10);
  /// How often delays are computed from what was gathered.
  std::chrono::nanoseconds update_interval = std::chrono::seconds(1);
  double min_speed_mps = 2.0;  ///< slower moments tell nothing
  /// Moments within a block of this length may err alike; blocks are independent.
  std::chrono::nanoseconds block = std::chrono::seconds(4);
  int min_block_count = 6;  ///< from which a variance can be told
  /// A radar whose speeds differ more from the reported ones says nothing.
  double max_residual_mps = 0.2;
  double sigma_floor_s = 0.003;  ///< no delay is known better by the drive
};
std::span<const OptionField<RadarDelayOptions>> FieldsOf(const RadarDelayOptions& options);
absl::Status Validate(const RadarDelayOptions& options);

/// Finds by how much later than the moment of its measurement each radar stamps its scans: by the
/// delay at which the reported velocity explains the speeds that its Doppler tells. For each of
/// some delays and each radar it keeps the regression of these speeds on reported speed and yaw
/// rate, so that no scale and no lever arm is taken for a delay.
class RadarDelays {
 public:
  /// Delays are those beyond what the rig describes.
  RadarDelays(Rig described, const RadarDelayOptions& options);

  /// As described.
  const Rig& rig() const { return described_; }

  /// A scan of radar `index` at `stamp`, which is not before the last one's, with the velocity that
  /// the vehicle reports with it. `is_sound`: wheels, gyroscope and Doppler are. Returns whether
  /// delays were computed anew.
  bool OnScan(Stamp stamp, std::size_t index, const Scan& scan, bool is_sound);

  /// What follows is another drive.
  void OnDiscontinuity();

  /// Computes the delays from what was gathered so far.
  void Update();

  /// By how much the Doppler of the radar follows the reported velocity [s], negative where that is
  /// late. Nothing while the drive does not tell.
  const std::optional<ScalarEstimate>& AgainstReported(std::size_t index) const {
    return radars_[index].delay_s;
  }

  /// By how much the radar's scans are stamped late [s] (METHOD eq 67).
  std::optional<ScalarEstimate> Late(std::size_t index) const;

 private:
  static constexpr int kSteps = 8;
  static constexpr int kCandidates = 2 * kSteps + 1;
  static constexpr int kMargin = 2;  // steps over which reported velocities are averaged

  struct Reported {
    Stamp stamp;
    double speed_mps, yaw_rate_radps;
    double distance_m, turn_rad;  // their integrals
  };
  struct Moment {
    Stamp stamp;
    std::size_t index;
    double speed_mps;
  };
  // Sums of a regression of a speed y on (1, v, w); older ones count less.
  struct Sums {
    double n = 0.0, v = 0.0, w = 0.0, y = 0.0;
    double vv = 0.0, vw = 0.0, ww = 0.0, vy = 0.0, wy = 0.0, yy = 0.0;
  };
  struct Fit {
    double offset = 0.0, per_speed = 1.0, per_yaw_rate = 0.0;
    double variance = 0.0;
  };
  struct Radar {
    std::array<Sums, kCandidates> sums;
    std::optional<Stamp> last, last_added;
    // Of the newest Update.
    int best = kSteps;
    double vertex_steps = 0.0;  // from `best`
    Fit fit;
    bool is_solved = false;
    // Of blocks: the sum of the scores' squares.
    std::optional<Stamp> block_begin;
    double block_score = 0.0, score_square = 0.0;
    int block_count = 0;
    std::optional<ScalarEstimate> delay_s;
  };

  void AddReported(Stamp stamp, const EgoVelocity& velocity);
  void AddMoments();
  void Add(const Moment& moment);
  static Fit FitOf(const Sums& sums);
  void Solve(Radar& radar) const;
  double StepSeconds() const;

  RadarDelayOptions options_;
  Rig described_;
  RadarSpeed speed_;
  std::vector<Radar> radars_;
  std::vector<Reported> reported_;  // the newest last
  std::vector<Moment> waiting_;     // of which not all that is compared is known yet
  std::optional<Stamp> updated_;
};

}  // namespace dcloc
