#include "client/sdk/requests.h"

#include <cmath>

namespace dcloc::client {

v1::OpenSession OpenRequest(const std::string& vehicle_id, const std::string& map_name,
                            const std::vector<MountedRadar>& radars) {
  v1::OpenSession open;
  open.set_vehicle_id(vehicle_id);
  open.set_map_name(map_name);
  for (const MountedRadar& radar : radars) {
    v1::RadarModel& model = *open.mutable_rig()->add_radars();
    model.set_radar_id(radar.radar_id);
    model.set_beta_s(radar.beta_s);
    v1::Vector3& translation_m = *model.mutable_t_vehicle_radar()->mutable_translation_m();
    translation_m.set_x(radar.translation_m[0]);
    translation_m.set_y(radar.translation_m[1]);
    translation_m.set_z(radar.translation_m[2]);
    v1::Quaternion& rotation = *model.mutable_t_vehicle_radar()->mutable_rotation();
    rotation.set_w(std::cos(0.5 * radar.yaw_rad));
    rotation.set_z(std::sin(0.5 * radar.yaw_rad));
  }
  return open;
}

v1::Scan ScanOf(const std::string& radar_id, std::int64_t stamp_ns,
                std::span<const Target> targets) {
  v1::Scan scan;
  scan.set_radar_id(radar_id);
  scan.set_stamp_ns(stamp_ns);
  for (const Target& target : targets) {
    scan.add_range_m(target.range_m);
    scan.add_azimuth_rad(target.azimuth_rad);
    scan.add_range_rate_mps(target.range_rate_mps);
  }
  return scan;
}

}  // namespace dcloc::client
