#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "client/simulation/simulation.h"
#include "core/map/map_builder.h"
#include "server/convert/geometry.h"
#include "tests/server/messages.h"

namespace dcloc::server {

/// A drive through a simulated town, and the map of another one.
struct TownDrive {
  explicit TownDrive(double length_m = 200.0) {
    SimulationOptions options;
    options.length_m = length_m;
    const std::vector<PassOptions> passes = Passes(options);
    mapping = *SimulatePass(options, passes[0]);
    map = Map("town");
    live = *SimulatePass(options, passes[1]);
  }

  /// The map's bytes; another name gives other bytes and the same landmarks.
  std::vector<std::byte> Map(const std::string& name) const {
    MapBuilder builder = *MapBuilder::Create(mapping.rig, {.name = name});
    for (const DriveScan& scan : mapping.scans) {
      const absl::Status status =
          builder.Add(scan.scan, scan.T_map_vehicle, *scan.scan.ego_velocity);
      if (!status.ok()) std::abort();  // the simulator made what no map is made of
    }
    return *builder.Build();
  }

  /// As messages, numbered from 0.
  std::vector<v1::Scan> Scans() const {
    std::vector<v1::Scan> scans;
    for (std::size_t i = 0; i < live.scans.size(); ++i) {
      scans.push_back(MessageOf(live.scans[i].scan, static_cast<std::int64_t>(i)));
    }
    return scans;
  }

  v1::OpenSession Open() const {
    v1::OpenSession open = OpenMessage();
    *open.mutable_rig() = RigMessage(live.rig);
    convert::ToProto(live.scans[0].T_map_vehicle, open.mutable_initial_pose()->mutable_pose());
    return open;
  }

  /// Of the rig's first radar, which is its only one.
  static v1::Rig RigMessage(const Rig& rig) {
    v1::Rig message;
    const RadarModel& model = rig.radars[0];
    v1::RadarModel* radar = message.add_radars();
    radar->set_radar_id(model.id);
    convert::ToProto(model.T_vehicle_radar, radar->mutable_t_vehicle_radar());
    radar->set_beta_s(model.beta_s);
    radar->set_range_sigma_m(model.range_sigma_m);
    radar->set_range_rate_sigma_mps(model.range_rate_sigma_mps);
    radar->set_azimuth_sigma_rad(model.azimuth_sigma_rad);
    return message;
  }

  Drive mapping;
  std::vector<std::byte> map;
  Drive live;
};

}  // namespace dcloc::server
