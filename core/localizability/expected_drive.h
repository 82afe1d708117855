#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/localizability/alias_finder.h"
#include "core/localizability/expected_scans.h"
#include "core/localizability/keyframe_path.h"
#include "core/localizer/localizer.h"
#include "core/localizer/localizer_snapshot.h"
#include "core/map/radar_map.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/submap/submap.h"

namespace dcloc {

/// The vehicle that drives through a map.
struct ExpectedVehicle {
  Rig rig;  ///< what it is described as; biases, couplings and offsets are taken to be known
  ExpectedScanOptions scans;
  double speed_mps = 10.0;              ///< along the keyframes
  double scan_period_s = 0.075;         ///< of each radar
  double speed_sigma_mps = 0.02;        ///< noise of the wheels
  double speed_scale_error = 0.005;     ///< by which wheels are too fast
  double yaw_rate_sigma_radps = 0.001;  ///< noise of the gyroscope
  double yaw_rate_bias_radps = 0.0005;
  // What it learns of noise at the least (`NoiseScaleOptions`), as vehicles in towns do: a world is
  // less like its map than a map is like itself.
  double min_registration_ratio = 2.2;
  double min_odometry_ratio = 0.003;
};
std::span<const OptionField<ExpectedVehicle>> FieldsOf(const ExpectedVehicle& vehicle);

/// OK, or InvalidArgument that names the field or the radar.
absl::Status Validate(const ExpectedVehicle& vehicle);

/// What a vehicle was told near one keyframe.
struct AnswerSum {
  int count = 0;
  int tracking_count = 0;
  int posed_count = 0;     ///< with a pose
  int observed_count = 0;  ///< of these, that observe the way along
  Vector6d variance = Vector6d::Zero();

  void Add(const Localization& answer);
};

/// One drive through a stretch of a map.
class ExpectedDrive {
 public:
  /// `vehicle` is valid and outlives it. `is_tunnel` as of `ExpectedScans`.
  ExpectedDrive(std::shared_ptr<const RadarMap> map, const Stretch& stretch,
                const ExpectedVehicle& vehicle, std::vector<bool> is_tunnel, std::uint64_t seed);

  /// The vehicle begins at the first keyframe. It has `learned` what an earlier drive left it with:
  /// of noise and odometry, and how sure it may be.
  absl::Status Run(const std::optional<LocalizerSnapshot>& learned);

  /// What it has learned: the last that there was. Nothing where it was never tracked.
  const std::optional<LocalizerSnapshot>& learned() const { return learned_; }

  const std::vector<AnswerSum>& sums() const { return sums_; }    ///< by keyframe of the stretch
  const std::vector<PlaceView>& views() const { return views_; }  ///< likewise
  double duration_s() const { return path_.duration_s(); }

 private:
  absl::StatusOr<Localizer> Begin(const std::optional<LocalizerSnapshot>& learned);
  Scan TakeScan(const RadarModel& radar, const PathPoint& point, Stamp stamp);
  void KeepView(const Scan& scan, std::size_t radar, const PathPoint& point,
                const Pose3& T_before_now);

  std::shared_ptr<const RadarMap> map_;
  Stretch stretch_;
  const ExpectedVehicle& vehicle_;
  Rig rig_;
  KeyframePath path_;
  ExpectedScans scans_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Stamp begin_{};
  SubmapWindow window_;
  LiveSubmap<2> submap_;
  std::optional<LocalizerSnapshot> learned_;
  std::vector<AnswerSum> sums_;
  std::vector<PlaceView> views_;
};

}  // namespace dcloc
