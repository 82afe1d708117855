#include "client/simulation/change_description.h"

namespace dcloc {

using nlohmann::ordered_json;

ordered_json ScattererChanges(const std::vector<simulation::ScattererChange>& changes) {
  ordered_json list = ordered_json::array();
  for (const simulation::ScattererChange& change : changes) {
    const simulation::Scatterer& scatterer = change.scatterer;
    list.push_back({{"came", change.came},
                    {"cause", change.cause},
                    {"x_m", scatterer.position_m.x()},
                    {"y_m", scatterer.position_m.y()},
                    {"z_m", scatterer.position_m.z()},
                    {"rcs_dbsm", scatterer.rcs_dbsm},
                    {"facing_rad", scatterer.facing_rad},
                    {"half_sector_rad", scatterer.half_sector_rad}});
  }
  return list;
}

ordered_json ParkedVehicles(const SimulatedPass& pass) {
  ordered_json list = ordered_json::array();
  for (const simulation::ParkedVehicle& parked : pass.parked) {
    list.push_back({{"slot", parked.slot},
                    {"x_m", parked.T_map_body.translation_m.x()},
                    {"y_m", parked.T_map_body.translation_m.y()},
                    {"yaw_rad", parked.T_map_body.yaw_rad},
                    {"length_m", parked.vehicle.length_m},
                    {"width_m", parked.vehicle.width_m}});
  }
  return list;
}

ordered_json AgeingDescription(const SimulationOptions& options) {
  return {{"day", options.day},
          {"vehicle_count", options.vehicle_count},
          {"replaced_share", options.ageing.replaced_share},
          {"site_m", options.ageing.site_m},
          {"post_count", options.ageing.post_count},
          {"gone_wall_m", options.ageing.gone_wall_m},
          {"leaf_count", options.ageing.leaf_count}};
}

}  // namespace dcloc
