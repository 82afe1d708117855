#pragma once

#include <filesystem>

#include "absl/status/status.h"
#include "core/radar/radar_model.h"

namespace dcloc {

/// Name of the file beside the tables of a nuScenes-like dataset that says how its radars measure,
/// which the official tables have no place for:
/// `{"radars": [{"id": "RADAR_FRONT", "beta_s": 0.04, "range_sigma_m": 0.1, ...}]}`.
/// Keys are RadarModel's fields; all but `id` may be left out, which keeps the model's value.
inline constexpr const char* kRigFileName = "dcloc_rig.json";

/// Takes over what the file says of the radars of `rig`; its other radars are ignored. DataLoss for
/// a radar of the rig that it does not list, for unknown keys and for values of a wrong type.
absl::Status ApplyRigFile(const std::filesystem::path& path, Rig& rig);

}  // namespace dcloc
