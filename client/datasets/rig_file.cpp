#include "client/datasets/rig_file.h"

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/json_file.h"

namespace dcloc {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<const char*, double RadarModel::*>, 12> kNumbers = {
    {{"beta_s", &RadarModel::beta_s},
     {"range_bias_m", &RadarModel::range_bias_m},
     {"time_offset_s", &RadarModel::time_offset_s},
     {"beta_sigma_s", &RadarModel::beta_sigma_s},
     {"range_bias_sigma_m", &RadarModel::range_bias_sigma_m},
     {"time_offset_sigma_s", &RadarModel::time_offset_sigma_s},
     {"mount_yaw_sigma_rad", &RadarModel::mount_yaw_sigma_rad},
     {"range_sigma_m", &RadarModel::range_sigma_m},
     {"range_rate_sigma_mps", &RadarModel::range_rate_sigma_mps},
     {"azimuth_sigma_rad", &RadarModel::azimuth_sigma_rad},
     {"elevation_sigma_rad", &RadarModel::elevation_sigma_rad},
     {"unambiguous_range_rate_mps", &RadarModel::unambiguous_range_rate_mps}}};

double* NumberField(RadarModel& radar, const std::string& key) {
  for (const auto& [name, member] : kNumbers) {
    if (key == name) return &(radar.*member);
  }
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

nlohmann::ordered_json RigJson(const Rig& rig) {
  auto radars = nlohmann::ordered_json::array();
  for (const RadarModel& radar : rig.radars) {
    nlohmann::ordered_json entry = {{"id", radar.id}, {"has_elevation", radar.has_elevation}};
    for (const auto& [name, member] : kNumbers) entry[name] = radar.*member;
    radars.push_back(std::move(entry));
  }
  return {{"radars", std::move(radars)}};
}

}  // namespace dcloc
