#include "client/datasets/radarscenes_tables.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/hdf5_table.h"
#include "client/datasets/files/json_file.h"
#include "client/datasets/files/json_table.h"

namespace dcloc {
namespace {

using nlohmann::json;

constexpr auto kInteger = Hdf5Column::Type::kInt64;
constexpr auto kFloat = Hdf5Column::Type::kFloat;

absl::StatusOr<double> Number(const json& object, const char* key) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_number()) {
    return absl::DataLossError(absl::StrCat("\"", key, "\" must be a number"));
  }
  return object[key].get<double>();
}

absl::StatusOr<std::int64_t> Integer(const json& object, const char* key) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_number_integer()) {
    return absl::DataLossError(absl::StrCat("\"", key, "\" must be an integer"));
  }
  return object[key].get<std::int64_t>();
}

absl::StatusOr<Pose3> ReadMount(const json& sensor) {
  const auto x_m = Number(sensor, "x");
  if (!x_m.ok()) return x_m.status();
  const auto y_m = Number(sensor, "y");
  if (!y_m.ok()) return y_m.status();
  const auto yaw_rad = Number(sensor, "yaw");
  if (!yaw_rad.ok()) return yaw_rad.status();
  return Embed(Pose2{{*x_m, *y_m}, *yaw_rad});
}

absl::StatusOr<RadarScenesScene> ReadScene(const std::string& key, const json& entry) {
  RadarScenesScene scene;
  if (!absl::SimpleAtoi(key, &scene.timestamp_us) || scene.timestamp_us < -kMaxTime_us ||
      scene.timestamp_us > kMaxTime_us) {
    return absl::DataLossError("its key must be a time in microseconds");
  }
  const auto sensor_id = Integer(entry, "sensor_id");
  if (!sensor_id.ok()) return sensor_id.status();
  scene.sensor_id = *sensor_id;
  const auto indices = entry.find("radar_indices");
  if (indices == entry.end() || !indices->is_array() || indices->size() != 2 ||
      !(*indices)[0].is_number_unsigned() || !(*indices)[1].is_number_unsigned()) {
    return absl::DataLossError("\"radar_indices\" must be two row numbers");
  }
  scene.begin = (*indices)[0].get<std::size_t>();
  scene.end = (*indices)[1].get<std::size_t>();
  if (scene.begin > scene.end) {
    return absl::DataLossError(
        absl::StrCat("\"radar_indices\" run backwards, ", scene.begin, " to ", scene.end));
  }
  return scene;
}

}  // namespace

absl::StatusOr<std::vector<RadarScenesTarget>> ReadRadarScenesTargets(
    const std::filesystem::path& radar_data_h5) {
  constexpr std::array<Hdf5Column, 6> kColumns = {{
      {"timestamp", kInteger, offsetof(RadarScenesTarget, timestamp_us)},
      {"sensor_id", kInteger, offsetof(RadarScenesTarget, sensor_id)},
      {"range_sc", kFloat, offsetof(RadarScenesTarget, range_m)},
      {"azimuth_sc", kFloat, offsetof(RadarScenesTarget, azimuth_rad)},
      {"rcs", kFloat, offsetof(RadarScenesTarget, rcs_dbsm)},
      {"vr", kFloat, offsetof(RadarScenesTarget, range_rate_mps)},
  }};
  return ReadHdf5Table<RadarScenesTarget>(radar_data_h5, "radar_data", kColumns);
}

absl::StatusOr<std::vector<RadarScenesOdometry>> ReadRadarScenesOdometry(
    const std::filesystem::path& radar_data_h5) {
  constexpr std::array<Hdf5Column, 6> kColumns = {{
      {"timestamp", kInteger, offsetof(RadarScenesOdometry, timestamp_us)},
      {"x_seq", kFloat, offsetof(RadarScenesOdometry, x_m)},
      {"y_seq", kFloat, offsetof(RadarScenesOdometry, y_m)},
      {"yaw_seq", kFloat, offsetof(RadarScenesOdometry, yaw_rad)},
      {"vx", kFloat, offsetof(RadarScenesOdometry, vx_mps)},
      {"yaw_rate", kFloat, offsetof(RadarScenesOdometry, yaw_rate_radps)},
  }};
  auto rows = ReadHdf5Table<RadarScenesOdometry>(radar_data_h5, "odometry", kColumns);
  if (!rows.ok()) return rows.status();
  const auto backwards = std::adjacent_find(
      rows->begin(), rows->end(),
      [](const auto& a, const auto& b) { return b.timestamp_us <= a.timestamp_us; });
  if (backwards != rows->end()) {
    return FileError(radar_data_h5,
                     absl::StrCat("data set \"odometry\" row ", backwards - rows->begin() + 1,
                                  " is not after the row before it"));
  }
  return rows;
}

absl::StatusOr<std::map<std::int64_t, Pose3>> ReadRadarScenesMounts(
    const std::filesystem::path& sensors_json) {
  const auto document = ReadJson(sensors_json);
  if (!document.ok()) return document.status();
  if (!document->is_object()) return FileError(sensors_json, "must be an object of sensors");
  std::map<std::int64_t, Pose3> mounts;
  for (const auto& [name, sensor] : document->items()) {
    if (!name.starts_with("radar")) continue;
    const auto id = Integer(sensor, "id");
    const auto mount = id.ok() ? ReadMount(sensor) : id.status();
    if (!mount.ok()) {
      return FileError(sensors_json, absl::StrCat(name, ": ", mount.status().message()));
    }
    mounts.emplace(*id, *mount);
  }
  if (mounts.empty()) return FileError(sensors_json, "lists no radar");
  return mounts;
}

absl::StatusOr<std::vector<RadarScenesScene>> ReadRadarScenesScenes(
    const std::filesystem::path& scenes_json) {
  const auto document = ReadJson(scenes_json);
  if (!document.ok()) return document.status();
  if (!document->is_object() || !document->contains("scenes") ||
      !(*document)["scenes"].is_object()) {
    return FileError(scenes_json, "must be an object with an object \"scenes\"");
  }
  std::vector<RadarScenesScene> scenes;
  for (const auto& [key, entry] : (*document)["scenes"].items()) {
    const auto scene = ReadScene(key, entry);
    if (!scene.ok()) {
      return FileError(scenes_json, absl::StrCat("scene ", key, ": ", scene.status().message()));
    }
    scenes.push_back(*scene);
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const auto& a, const auto& b) { return a.timestamp_us < b.timestamp_us; });
  return scenes;
}

}  // namespace dcloc
