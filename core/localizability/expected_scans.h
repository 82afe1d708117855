#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/map/radar_map.h"
#include "core/options/option_fields.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// What a radar sees of the landmarks around it.
struct ExpectedScanOptions {
  double landmark_targets = 35.0;     ///< of a scan, on landmarks, where there are enough of them
  double max_hit_probability = 0.5;   ///< of one landmark, in one scan
  double unmapped_share = 0.25;       ///< of all targets: on what no map holds
  double max_range_m = 80.0;          ///< of the radar
  double half_field_of_view_rad = 1;  ///< to either side of its axis
  double wall_m = 10.0;               ///< in a tunnel a return may come from so far along the wall
};
std::span<const OptionField<ExpectedScanOptions>> FieldsOf(const ExpectedScanOptions& options);
absl::Status Validate(const ExpectedScanOptions& options);

/// Scans as a vehicle would take them in a map. Landmarks are hit as often as the mapping scans saw
/// them. A return lies where the landmark's covariance says that a further one may lie, and is
/// measured with the radar's noise. In a tunnel it lies anywhere along the wall: what a smooth wall
/// shows goes with the vehicle. What hides what is not known to a map.
class ExpectedScans {
 public:
  /// `options` are valid. The same seed gives the same scans.
  /// `is_tunnel` says it of each keyframe; empty: there is no tunnel.
  ExpectedScans(std::shared_ptr<const RadarMap> map, const ExpectedScanOptions& options,
                std::vector<bool> is_tunnel, std::uint64_t seed)
      : map_(std::move(map)), options_(options), is_tunnel_(std::move(is_tunnel)), random_(seed) {}

  /// The scan of `radar` at a pose of the vehicle that moves by `velocity` (vehicle frame), without
  /// an ego-velocity. Ranges are free of bias and coupling.
  Scan At(const RadarModel& radar, const Pose3& T_map_vehicle, const EgoVelocity& velocity,
          Stamp stamp);

 private:
  // In the map frame. The height is over the radars, where the map knows it.
  struct Scatterer {
    Eigen::Vector3d p_map_m;
    Eigen::Matrix3d spread_map_m;  // times a normal vector: where a return lies
    std::optional<double> height_m;
    double weight = 0.0;
    Eigen::Vector3d wall_map_m = Eigen::Vector3d::Zero();  // from its middle to its end
  };
  struct Echo {
    Eigen::Vector3d p_radar_m;
    double weight = 0.0;
  };

  void GatherAround(const Eigen::Vector3d& p_map_m);
  Eigen::Vector3d Normal();
  bool IsInView(const Eigen::Vector3d& p_radar_m) const;
  void Measure(const RadarModel& radar, const Eigen::Vector3d& p_radar_m,
               const Eigen::Vector3d& velocity_mps, Scan& scan);

  std::shared_ptr<const RadarMap> map_;
  ExpectedScanOptions options_;
  std::vector<bool> is_tunnel_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  std::optional<std::size_t> keyframe_;  // that the scatterers are around
  std::vector<Scatterer> scatterers_;
  std::vector<Echo> echoes_;  // kept for its memory
};

}  // namespace dcloc
