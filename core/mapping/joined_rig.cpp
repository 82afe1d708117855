#include "core/mapping/joined_rig.h"

#include "absl/strings/str_cat.h"

namespace dcloc {
namespace {

// All that a map made with it depends on.
bool IsAlike(const RadarModel& a, const RadarModel& b) {
  return a.T_vehicle_radar.translation_m == b.T_vehicle_radar.translation_m &&
         a.T_vehicle_radar.rotation.coeffs() == b.T_vehicle_radar.rotation.coeffs() &&
         a.beta_s == b.beta_s && a.range_bias_m == b.range_bias_m &&
         a.time_offset_s == b.time_offset_s && a.range_sigma_m == b.range_sigma_m &&
         a.azimuth_sigma_rad == b.azimuth_sigma_rad &&
         a.elevation_sigma_rad == b.elevation_sigma_rad && a.has_elevation == b.has_elevation &&
         a.range_rate_sigma_mps == b.range_rate_sigma_mps &&
         a.unambiguous_range_rate_mps == b.unambiguous_range_rate_mps;
}

}  // namespace

void JoinedRig::Add(const std::string& drive, const Rig& rig) {
  for (const RadarModel& radar : rig.radars) {
    const std::string id = IdOf(drive, radar);
    if (rig_.Find(id) != nullptr) continue;
    rig_.radars.push_back(radar);
    rig_.radars.back().id = id;
  }
}

std::string JoinedRig::IdOf(const std::string& drive, const RadarModel& radar) const {
  const RadarModel* const known = rig_.Find(radar.id);
  if (known == nullptr || IsAlike(*known, radar)) return radar.id;
  return absl::StrCat(radar.id, "@", drive);
}

}  // namespace dcloc
