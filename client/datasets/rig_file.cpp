#include "client/datasets/rig_file.h"

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/datasets/file_error.h"
#include "client/datasets/json_file.h"

namespace dcloc {
namespace {

using nlohmann::json;

double* NumberField(RadarModel& radar, const std::string& key) {
  if (key == "beta_s") return &radar.beta_s;
  if (key == "range_bias_m") return &radar.range_bias_m;
  if (key == "time_offset_s") return &radar.time_offset_s;
  if (key == "beta_sigma_s") return &radar.beta_sigma_s;
  if (key == "range_bias_sigma_m") return &radar.range_bias_sigma_m;
  if (key == "time_offset_sigma_s") return &radar.time_offset_sigma_s;
  if (key == "mount_yaw_sigma_rad") return &radar.mount_yaw_sigma_rad;
  if (key == "range_sigma_m") return &radar.range_sigma_m;
  if (key == "range_rate_sigma_mps") return &radar.range_rate_sigma_mps;
  if (key == "azimuth_sigma_rad") return &radar.azimuth_sigma_rad;
  if (key == "elevation_sigma_rad") return &radar.elevation_sigma_rad;
  if (key == "unambiguous_range_rate_mps") return &radar.unambiguous_range_rate_mps;
  return nullptr;
}

void TurnMount(double yaw_rad, RadarModel& radar) {
  Eigen::Quaterniond& rotation = radar.T_vehicle_radar.rotation;
  rotation = (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * rotation).normalized();
}

absl::Status ApplyField(const std::string& key, const json& value, RadarModel& radar) {
  if (key == "id") return absl::OkStatus();
  if (key == "has_elevation") {
    if (!value.is_boolean()) return absl::DataLossError("\"has_elevation\" must be true or false");
    radar.has_elevation = value.get<bool>();
    return absl::OkStatus();
  }
  double* const field = NumberField(radar, key);
  const bool is_mount_yaw = key == "mount_yaw_correction_rad";
  if (field == nullptr && !is_mount_yaw) {
    return absl::DataLossError(absl::StrCat("unknown key \"", key, "\""));
  }
  if (!value.is_number()) {
    return absl::DataLossError(absl::StrCat("\"", key, "\" must be a number"));
  }
  if (is_mount_yaw) {
    TurnMount(value.get<double>(), radar);
  } else {
    *field = value.get<double>();
  }
  return absl::OkStatus();
}

absl::Status ApplyRadar(const json& entry, RadarModel& radar) {
  for (const auto& [key, value] : entry.items()) {
    if (absl::Status status = ApplyField(key, value, radar); !status.ok()) {
      return absl::DataLossError(absl::StrCat("radar ", radar.id, ": ", status.message()));
    }
  }
  return Validate(radar);
}

// The entries by their radar's id.
absl::StatusOr<std::map<std::string, const json*>> EntriesById(const json& document) {
  if (!document.is_object() || !document.contains("radars") || !document["radars"].is_array()) {
    return absl::DataLossError("must be an object with an array \"radars\"");
  }
  std::map<std::string, const json*> entries;
  for (const json& entry : document["radars"]) {
    if (!entry.is_object() || !entry.contains("id") || !entry["id"].is_string()) {
      return absl::DataLossError("each of \"radars\" must be an object with a string \"id\"");
    }
    const auto id = entry["id"].get<std::string>();
    if (!entries.emplace(id, &entry).second) {
      return absl::DataLossError(absl::StrCat("lists radar ", id, " twice"));
    }
  }
  return entries;
}

}  // namespace

absl::Status ApplyRigFile(const std::filesystem::path& path, Rig& rig) {
  const auto document = ReadJson(path);
  if (!document.ok()) return document.status();
  const auto entries = EntriesById(*document);
  if (!entries.ok()) return FileError(path, entries.status().message());
  for (RadarModel& radar : rig.radars) {
    const auto entry = entries->find(radar.id);
    if (entry == entries->end()) {
      return FileError(path, absl::StrCat("does not list radar ", radar.id));
    }
    if (absl::Status status = ApplyRadar(*entry->second, radar); !status.ok()) {
      return FileError(path, status.message());
    }
  }
  return absl::OkStatus();
}

}  // namespace dcloc
