#include "client/simulation/radar/radar_profile.h"

#include <array>

#include "core/geometry/degrees.h"

namespace dcloc::simulation {
namespace {

struct Mount {
  const char* id;
  double x_m, y_m, z_m, yaw_deg;
};

constexpr std::array<Mount, 5> kMounts = {{{"RADAR_FRONT", 3.41, 0.0, 0.50, 0.0},
                                           {"RADAR_FRONT_LEFT", 2.42, 0.80, 0.78, 90.0},
                                           {"RADAR_FRONT_RIGHT", 2.42, -0.80, 0.77, -90.0},
                                           {"RADAR_BACK_LEFT", -0.56, 0.62, 0.53, 175.0},
                                           {"RADAR_BACK_RIGHT", -0.56, -0.62, 0.53, -175.0}}};

}  // namespace

RadarProfile Ars408Profile() {
  RadarProfile profile;
  profile.period_s = 0.075;
  profile.max_range_m = 100.0;
  profile.half_field_rad = 60.0 * kRadPerDeg;
  profile.far_max_range_m = 250.0;
  profile.far_half_field_rad = 9.0 * kRadPerDeg;
  profile.reference_range_m = 95.0;
  profile.edge_loss_db = 12.0;
  profile.far_gain_db = 10.0;
  profile.elevation_half_power_rad = 7.0 * kRadPerDeg;
  profile.range_m.scale = 0.15;
  profile.azimuth_rad.scale = 1.0 * kRadPerDeg;
  profile.elevation_rad.scale = 1.5 * kRadPerDeg;
  profile.range_rate_mps.scale = 0.1;
  profile.noise_depends_on_target = true;
  return profile;
}

RadarProfile CarlaProfile(NoiseKind kind) {
  RadarProfile profile;
  profile.period_s = 0.075;
  profile.max_range_m = 100.0;
  profile.half_field_rad = 75.0 * kRadPerDeg;
  profile.reference_range_m = 150.0;
  profile.edge_loss_db = 3.0;
  profile.elevation_half_power_rad = 15.0 * kRadPerDeg;
  profile.min_rcs_dbsm = -15.0;
  profile.range_resolution_m = 0.1;
  profile.azimuth_resolution_rad = 0.2 * kRadPerDeg;
  profile.range_rate_resolution_mps = 0.1;
  profile.min_targets = 100;
  profile.max_targets = 150;
  profile.miss_probability = 0.0;
  profile.selection_noise_db = 60.0;

  const bool is_rayleigh = kind == NoiseKind::kRayleigh;
  const double angle_deg = is_rayleigh ? 1.0 : kind == NoiseKind::kGamma ? 0.025 : 0.5;
  profile.range_m = {kind, is_rayleigh ? 0.5 : 0.25};
  profile.azimuth_rad = {kind, angle_deg * kRadPerDeg};
  profile.elevation_rad = {kind, angle_deg * kRadPerDeg};
  profile.range_rate_mps = {kind, 0.1};
  return profile;
}

Rig MakeRig(const RadarProfile& profile, int radar_count, double beta_s, bool has_elevation,
            double unambiguous_range_rate_mps) {
  Rig rig;
  for (const Mount& mount : kMounts) {
    if (static_cast<int>(rig.radars.size()) == radar_count) break;
    RadarModel radar;
    radar.id = mount.id;
    radar.T_vehicle_radar.translation_m = {mount.x_m, mount.y_m, mount.z_m};
    radar.T_vehicle_radar.rotation =
        Eigen::AngleAxisd(mount.yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ());
    radar.beta_s = beta_s;
    // As described, to the last digit.
    radar.beta_sigma_s = radar.range_bias_sigma_m = 0.0;
    radar.time_offset_sigma_s = radar.mount_yaw_sigma_rad = 0.0;
    radar.range_sigma_m = profile.range_m.StandardDeviation();
    radar.azimuth_sigma_rad = profile.azimuth_rad.StandardDeviation();
    radar.range_rate_sigma_mps = profile.range_rate_mps.StandardDeviation();
    if (has_elevation) radar.elevation_sigma_rad = profile.elevation_rad.StandardDeviation();
    radar.has_elevation = has_elevation;
    radar.unambiguous_range_rate_mps = unambiguous_range_rate_mps;
    rig.radars.push_back(radar);
  }
  return rig;
}

}  // namespace dcloc::simulation
