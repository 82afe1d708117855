#include "core/radar/radar_model.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

absl::Status CheckBetween(const RadarModel& radar, const char* field, double value, double min,
                          double max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat("radar '%s': %s is %g; it must lie in [%g, %g]",
                                                    radar.id, field, value, min, max));
}

}  // namespace

const RadarModel* Rig::Find(std::string_view id) const {
  for (const RadarModel& radar : radars) {
    if (radar.id == id) return &radar;
  }
  return nullptr;
}

bool Rig::MeasuresElevation() const {
  for (const RadarModel& radar : radars) {
    if (!radar.has_elevation) return false;
  }
  return !radars.empty();
}

bool Rig::HasKnownStamps() const {
  return !radars.empty() && std::ranges::all_of(radars, [](const RadarModel& radar) {
    return radar.time_offset_sigma_s > 0.0 && radar.time_offset_sigma_s <= kKnownTimeOffsetSigma_s;
  });
}

absl::Status Validate(const RadarModel& radar) {
  constexpr double kMaxMount_m = 100.0;
  const Eigen::Vector3d& mount = radar.T_vehicle_radar.translation_m;
  absl::Status status;
  if (radar.id.empty() || radar.id.size() > 64) {
    status = absl::InvalidArgumentError(absl::StrFormat(
        "a radar's id has %d characters; it must have between 1 and 64", radar.id.size()));
  }
  status.Update(
      CheckBetween(radar, "T_vehicle_radar.translation_m.x", mount.x(), -kMaxMount_m, kMaxMount_m));
  status.Update(
      CheckBetween(radar, "T_vehicle_radar.translation_m.y", mount.y(), -kMaxMount_m, kMaxMount_m));
  status.Update(
      CheckBetween(radar, "T_vehicle_radar.translation_m.z", mount.z(), -kMaxMount_m, kMaxMount_m));
  status.Update(CheckBetween(radar, "T_vehicle_radar.rotation's norm",
                             radar.T_vehicle_radar.rotation.norm(), 1.0 - 1e-3, 1.0 + 1e-3));
  status.Update(CheckBetween(radar, "beta_s", radar.beta_s, -1.0, 1.0));
  status.Update(CheckBetween(radar, "range_bias_m", radar.range_bias_m, -10.0, 10.0));
  status.Update(CheckBetween(radar, "time_offset_s", radar.time_offset_s, -1.0, 1.0));
  status.Update(CheckBetween(radar, "beta_sigma_s", radar.beta_sigma_s, 0.0, 1.0));
  status.Update(CheckBetween(radar, "range_bias_sigma_m", radar.range_bias_sigma_m, 0.0, 10.0));
  status.Update(CheckBetween(radar, "time_offset_sigma_s", radar.time_offset_sigma_s, 0.0, 1.0));
  status.Update(CheckBetween(radar, "mount_yaw_sigma_rad", radar.mount_yaw_sigma_rad, 0.0, 1.0));
  status.Update(CheckBetween(radar, "range_sigma_m", radar.range_sigma_m, 1e-3, 100.0));
  status.Update(
      CheckBetween(radar, "range_rate_sigma_mps", radar.range_rate_sigma_mps, 1e-3, 100.0));
  status.Update(CheckBetween(radar, "azimuth_sigma_rad", radar.azimuth_sigma_rad, 1e-4, 1.0));
  status.Update(CheckBetween(radar, "elevation_sigma_rad", radar.elevation_sigma_rad, 1e-4, 1.0));
  status.Update(CheckBetween(radar, "unambiguous_range_rate_mps", radar.unambiguous_range_rate_mps,
                             0.0, 1000.0));
  return status;
}

absl::Status Validate(const Rig& rig) {
  if (rig.radars.empty() || rig.radars.size() > kMaxRadars) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "rig has %d radars; it must have between 1 and %d", rig.radars.size(), kMaxRadars));
  }
  std::set<std::string_view> ids;
  for (const RadarModel& radar : rig.radars) {
    if (absl::Status status = Validate(radar); !status.ok()) return status;
    if (!ids.insert(radar.id).second) {
      return absl::InvalidArgumentError(
          absl::StrFormat("rig has two radars with the id '%s'; ids must be unique", radar.id));
    }
  }
  return absl::OkStatus();
}

absl::Status Validate(const Scan& scan, const Rig& rig) {
  if (absl::Status status = Validate(scan); !status.ok()) return status;
  if (rig.Find(scan.radar_id) == nullptr) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "radar_id '%s' is not one of the rig's %d radars", scan.radar_id, rig.radars.size()));
  }
  return absl::OkStatus();
}

double BetaFromChirp(double centre_frequency_hz, double slope_hz_per_s) {  // METHOD eq 5
  return centre_frequency_hz / slope_hz_per_s;
}

}  // namespace dcloc
