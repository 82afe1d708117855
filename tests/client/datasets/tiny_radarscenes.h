#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {

struct TinyTarget {
  std::int64_t timestamp;
  std::uint8_t sensor_id;
  float range_sc, azimuth_sc, rcs, vr;
};

struct TinyOdometry {
  std::int64_t timestamp;
  float x_seq, y_seq, yaw_seq, vx, yaw_rate;
};

/// A sequence of four scans of two radars that drives at 10 m/s along x, in the official layout
/// (less the columns that nobody reads); a test may break it anywhere before it is written.
struct TinyRadarScenes {
  nlohmann::json sensors = {{"radar_1", {{"id", 1}, {"x", 3.6}, {"y", -0.8}, {"yaw", -1.5}}},
                            {"radar_2", {{"id", 2}, {"x", 3.9}, {"y", 0.0}, {"yaw", 0.0}}}};
  nlohmann::json scenes;
  std::vector<TinyTarget> targets = {{1000000, 2, 20.0F, 0.0F, 3.0F, -10.0F},
                                     {1000000, 2, 10.0F, 0.5F, 3.0F, 2.0F},
                                     {1030000, 1, 8.0F, -0.1F, 1.0F, 0.0F},
                                     {1060000, 2, 19.4F, 0.0F, 3.0F, -10.0F},
                                     {1240000, 1, 7.0F, -0.1F, 1.0F, 0.0F}};
  std::vector<TinyOdometry> odometry = {{990000, 5.0F, 1.0F, 0.0F, 10.0F, 0.0F},
                                        {1010000, 5.2F, 1.0F, 0.0F, 11.0F, 0.2F},
                                        {1110000, 6.2F, 1.0F, 0.0F, 12.0F, 0.0F}};
  std::string target_table = "radar_data";
  std::string range_column = "range_sc";
  bool range_is_text = false;

  TinyRadarScenes() {
    scenes["sequence_name"] = "sequence_7";
    AddScene(1000000, 2, 0, 2);
    AddScene(1030000, 1, 2, 3);
    AddScene(1060000, 2, 3, 4);
    AddScene(1240000, 1, 4, 5);
  }

  void AddScene(std::int64_t time_us, int sensor_id, int begin, int end) {
    scenes["scenes"][std::to_string(time_us)] = {{"sensor_id", sensor_id},
                                                 {"radar_indices", {begin, end}}};
  }

  void WriteTo(const TempFolder& folder) const {
    folder.Write("data/sensors.json", sensors.dump());
    folder.Write("data/sequence_7/scenes.json", scenes.dump());
    WriteHdf5((folder.path() / "data/sequence_7/radar_data.h5").string());
  }

 private:
  struct Column {
    const char* name;
    std::size_t offset;
    hid_t type;
  };

  void WriteHdf5(const std::string& path) const {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t text = H5Tcopy(H5T_C_S1);
    H5Tset_size(text, sizeof(float));
    WriteTable(file, target_table, targets,
               {{"timestamp", offsetof(TinyTarget, timestamp), H5T_NATIVE_INT64},
                {"sensor_id", offsetof(TinyTarget, sensor_id), H5T_NATIVE_UINT8},
                {range_column.c_str(), offsetof(TinyTarget, range_sc),
                 range_is_text ? text : H5T_NATIVE_FLOAT},
                {"azimuth_sc", offsetof(TinyTarget, azimuth_sc), H5T_NATIVE_FLOAT},
                {"rcs", offsetof(TinyTarget, rcs), H5T_NATIVE_FLOAT},
                {"vr", offsetof(TinyTarget, vr), H5T_NATIVE_FLOAT}});
    WriteTable(file, "odometry", odometry,
               {{"timestamp", offsetof(TinyOdometry, timestamp), H5T_NATIVE_INT64},
                {"x_seq", offsetof(TinyOdometry, x_seq), H5T_NATIVE_FLOAT},
                {"y_seq", offsetof(TinyOdometry, y_seq), H5T_NATIVE_FLOAT},
                {"yaw_seq", offsetof(TinyOdometry, yaw_seq), H5T_NATIVE_FLOAT},
                {"vx", offsetof(TinyOdometry, vx), H5T_NATIVE_FLOAT},
                {"yaw_rate", offsetof(TinyOdometry, yaw_rate), H5T_NATIVE_FLOAT}});
    H5Tclose(text);
    H5Fclose(file);
  }

  template <typename Row>
  static void WriteTable(hid_t file, const std::string& name, const std::vector<Row>& rows,
                         const std::vector<Column>& columns) {
    const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(Row));
    for (const Column& column : columns) H5Tinsert(type, column.name, column.offset, column.type);
    const hsize_t count = rows.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t set =
        H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (count > 0) H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data());
    H5Dclose(set);
    H5Sclose(space);
    H5Tclose(type);
  }
};

}  // namespace dcloc
