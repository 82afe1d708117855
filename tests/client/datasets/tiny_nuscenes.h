#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {

/// A target as the official PCD files store it; the defaults pass the default filter.
struct PcdPoint {
  float x, y, z = 0.0F;
  float vx = 0.0F, vy = 0.0F;
  float rcs = 5.0F;
  std::int8_t dyn_prop = 1;
  std::int8_t ambig_state = 3;
  std::int8_t invalid_state = 0;
};

inline constexpr const char* kPcdFields =
    "FIELDS x y z dyn_prop id rcs vx vy vx_comp vy_comp is_quality_valid ambig_state x_rms y_rms "
    "invalid_state pdh0 vx_rms vy_rms\n";
inline constexpr const char* kPcdTypes =
    "SIZE 4 4 4 1 2 4 4 4 4 4 1 1 1 1 1 1 1 1\n"
    "TYPE F F F I I F F F F F I I I I I I I I\n"
    "COUNT 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n";

/// The bytes of a radar PCD file in the official layout: 18 fields, 43 bytes a point.
inline std::string PcdBytes(const std::vector<PcdPoint>& points) {
  const std::string count = std::to_string(points.size());
  std::string bytes = std::string("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n") +
                      kPcdFields + kPcdTypes + "WIDTH " + count +
                      "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  const auto put = [&](auto value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  const auto put_codes = [&](std::initializer_list<std::int8_t> codes) {
    for (const std::int8_t code : codes) put(code);
  };
  for (const PcdPoint& p : points) {
    for (const float value : {p.x, p.y, p.z}) put(value);
    put(p.dyn_prop);
    put(std::int16_t{7});  // id
    for (const float value : {p.rcs, p.vx, p.vy, 0.0F, 0.0F}) put(value);
    put_codes({1, p.ambig_state, 19, 19, p.invalid_state, 1, 3, 3});
  }
  return bytes;
}

/// One scene of two radars, two sweeps each, driving at 10 m/s along the map's x axis from (100,
/// 50): something small that a test may break anywhere before it is written.
struct TinyNuScenes {
  std::map<std::string, nlohmann::json> tables;
  std::map<std::string, std::string> files;  ///< below the root
  std::string version = "v1.0-tiny";

  TinyNuScenes() {
    using nlohmann::json;
    tables["scene"] = {{{"token", "s1"}, {"name", "scene-0001"}, {"log_token", "l1"}},
                       {{"token", "s2"}, {"name", "scene-0002"}, {"log_token", "l1"}}};
    tables["log"] = {{{"token", "l1"}, {"location", "tiny-town"}}};
    tables["sensor"] = {{{"token", "f"}, {"channel", "RADAR_FRONT"}, {"modality", "radar"}},
                        {{"token", "b"}, {"channel", "RADAR_BACK_LEFT"}, {"modality", "radar"}},
                        {{"token", "c"}, {"channel", "CAM_FRONT"}, {"modality", "camera"}}};
    const auto mount = [](const char* token, const char* sensor, json translation, json rotation) {
      return json{{"token", token},
                  {"sensor_token", sensor},
                  {"translation", std::move(translation)},
                  {"rotation", std::move(rotation)},
                  {"camera_intrinsic", json::array()}};
    };
    tables["calibrated_sensor"] = {mount("cf", "f", {3.4, 0.0, 0.5}, {1.0, 0.0, 0.0, 0.0}),
                                   mount("cb", "b", {-0.5, 0.6, 0.5}, {0.0, 0.0, 0.0, 1.0}),
                                   mount("cc", "c", {1.7, 0.0, 1.5}, {1.0, 0.0, 0.0, 0.0})};
    tables["calibrated_sensor"][2]["camera_intrinsic"] = {{1.0, 0.0}, {0.0, 1.0}};
    tables["sample"] = {{{"token", "k1"}, {"scene_token", "s1"}, {"timestamp", 1000000}},
                        {{"token", "k2"}, {"scene_token", "s2"}, {"timestamp", 9000000}}};
    AddSweep("RADAR_FRONT", "cf", "k1", 1000000, {{20.0F, 0.0F, 0.0F, -10.0F, 0.0F}});
    AddSweep("RADAR_FRONT", "cf", "k1", 1080000,
             {{19.2F, 0.0F, 0.0F, -10.0F, 0.0F}, {3.0F, 4.0F, 0.0F, -10.0F, 0.0F}});
    AddSweep("RADAR_BACK_LEFT", "cb", "k1", 1040000, {{30.0F, 0.0F, 0.0F, 10.0F, 0.0F}});
    AddSweep("RADAR_BACK_LEFT", "cb", "k1", 1120000, {});
    AddSweep("CAM_FRONT", "cc", "k1", 1000000, {});
    AddSweep("RADAR_FRONT", "cf", "k2", 9000000, {{5.0F, 0.0F}});
    json bus = json::array();
    for (int i = 0; i < 12; ++i) {
      bus.push_back({{"utime", 990000 + 20000 * i},
                     {"vel", {10.0 + 0.1 * i, 0.0, 0.0}},
                     {"rotation_rate", {0.0, 0.0, 0.01 * i}},
                     {"pos", {0.0, 0.0, 0.0}}});
    }
    files["can_bus/scene-0001_pose.json"] = bus.dump();
  }

  void AddSweep(const std::string& channel, const std::string& calibrated_sensor,
                const std::string& sample, std::int64_t time_us,
                const std::vector<PcdPoint>& points) {
    const std::string token = channel + std::to_string(time_us);
    const std::string filename = "sweeps/" + channel + "/" + std::to_string(time_us) + ".pcd";
    tables["sample_data"].push_back({{"token", token},
                                     {"sample_token", sample},
                                     {"ego_pose_token", token},
                                     {"calibrated_sensor_token", calibrated_sensor},
                                     {"timestamp", time_us},
                                     {"filename", filename}});
    const double x_m = 100.0 + 10.0 * 1e-6 * static_cast<double>(time_us - 1000000);
    tables["ego_pose"].push_back({{"token", token},
                                  {"timestamp", time_us},
                                  {"translation", {x_m, 50.0, 0.0}},
                                  {"rotation", {1.0, 0.0, 0.0, 0.0}}});
    files[filename] = PcdBytes(points);
  }

  void WriteTo(const TempFolder& folder) const {
    for (const auto& [name, table] : tables) {
      folder.Write(version + "/" + name + ".json", table.dump());
    }
    for (const auto& [name, bytes] : files) folder.Write(name, bytes);
  }
};

}  // namespace dcloc
