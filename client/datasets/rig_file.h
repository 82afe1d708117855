#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "absl/status/status.h"
#include "core/radar/radar_model.h"

namespace dcloc {

/// Name of the file beside the tables of a nuScenes-like dataset that says how its radars measure,
/// which the official tables have no place for.
inline constexpr const char* kRigFileName = "dcloc_rig.json";

/// Applies a rig file to the radars of `rig`; other radars in the file are ignored: `{"radars":
/// [{"id": "RADAR_FRONT", "beta_s": 0.04, "mount_yaw_correction_rad": 0.01, ...}]}`. Keys are
/// RadarModel's numbers and `has_elevation`, and a yaw by which the mount is turned on about the
/// vehicle's z axis; all but `id` may be left out, which keeps the model's value. DataLoss for a
/// radar of the rig that the file does not list, for unknown keys and for values of a wrong type.
absl::Status ApplyRigFile(const std::filesystem::path& path, Rig& rig);

/// A rig file that says all of how the radars measure, which a rig file can say; not their mounts.
nlohmann::ordered_json RigJson(const Rig& rig);

}  // namespace dcloc
