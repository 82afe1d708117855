#include "tests/client/datasets/zod_writer.h"

#include <chrono>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/rosbag/bag_bytes.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using rosbag::AppendNumber;

const std::vector<std::pair<std::string, std::string>> kTypes = {
    {"scan_index", "<u4"},    {"timestamp", "<i8"},       {"radar_range", "<f4"},
    {"azimuth_angle", "<f4"}, {"elevation_angle", "<f4"}, {"range_rate", "<f4"},
    {"amplitude", "<f4"},     {"validity", "|i1"},        {"mode", "|u1"},
    {"quality", "|u1"}};

void WriteText(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

json Matrix(const Pose3& pose) {
  const Eigen::Matrix3d R = pose.Rotation();
  json rows = json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({R(i, 0), R(i, 1), R(i, 2), pose.translation_m[i]});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

void AppendTargets(const Scan& scan, std::uint32_t index, std::string& rows) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    AppendNumber(rows, index);
    AppendNumber(rows, static_cast<std::int64_t>(scan.stamp.time_since_epoch().count()));
    AppendNumber(rows, scan.range_m[i]);
    AppendNumber(rows, scan.azimuth_rad[i]);
    AppendNumber(rows, scan.elevation_rad[i]);
    AppendNumber(rows, scan.range_rate_mps[i]);
    AppendNumber(rows, 40.0F);
    AppendNumber(rows, std::int8_t{1});
    AppendNumber(rows, std::uint8_t{0});
    AppendNumber(rows, std::uint8_t{1});
  }
}

void AddSample(Stamp stamp, const DriveScan& entry, const Eigen::Vector3d& p_map_origin,
               json& motion) {
  const EgoVelocity& velocity = *entry.scan.ego_velocity;
  Pose3 pose = entry.T_map_vehicle;
  pose.translation_m -= p_map_origin;
  motion["timestamps"].push_back(std::chrono::duration<double>(stamp.time_since_epoch()).count());
  motion["poses"].push_back(Matrix(pose));
  motion["velocities"].push_back({velocity.linear_mps.x(), 0.0, 0.0});
  motion["angular_rates"].push_back({0.0, 0.0, -velocity.angular_radps.z()});
}

/// A sample at each scan, and one a moment before the first and after the last: the stamps of the
/// samples are seconds in double, and so up to 0.2 us off.
json MotionOf(const ZodDrive& entry) {
  json motion;
  const std::vector<DriveScan>& scans = entry.drive->scans;
  AddSample(scans.front().scan.stamp - std::chrono::milliseconds(50), scans.front(),
            entry.p_map_origin, motion);
  for (const DriveScan& scan : scans) AddSample(scan.scan.stamp, scan, entry.p_map_origin, motion);
  AddSample(scans.back().scan.stamp + std::chrono::milliseconds(50), scans.back(),
            entry.p_map_origin, motion);
  const GeodeticPosition origin = GeodeticFromMap(ZodAnchor(), entry.p_map_origin);
  motion["origin_lat_lon"] = {origin.latitude_deg, origin.longitude_deg};
  return motion;
}

}  // namespace

std::string NpyBytes(const std::vector<std::pair<std::string, std::string>>& types,
                     std::size_t row_count, const std::string& rows, bool fortran_order) {
  std::string fields;
  for (const auto& [name, type] : types) {
    absl::StrAppend(&fields, fields.empty() ? "" : ", ", "('", name, "', '", type, "')");
  }
  std::string header =
      absl::StrCat("{'descr': [", fields, "], 'fortran_order': ", fortran_order ? "True" : "False",
                   ", 'shape': (", row_count, ",), }");
  header.resize((header.size() + 11 + 63) / 64 * 64 - 10 - 1, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  AppendNumber(bytes, static_cast<std::uint16_t>(header.size()));
  return bytes + header + rows;
}

GeodeticAnchor ZodAnchor() { return {.origin = {.latitude_deg = 57.75, .longitude_deg = 12.0}}; }

void WriteZod(const std::vector<ZodDrive>& drives, const fs::path& root) {
  json list = {{"train", json::array()}, {"val", json::array()}};
  for (const ZodDrive& entry : drives) {
    const std::string folder = "drives/" + entry.id + "/";
    std::string rows;
    std::size_t row_count = 0;
    for (std::size_t i = 0; i < entry.drive->scans.size(); ++i) {
      AppendTargets(entry.drive->scans[i].scan, static_cast<std::uint32_t>(i), rows);
      row_count += entry.drive->scans[i].scan.size();
    }
    WriteText(root / (folder + "radar_front/radar.npy"), NpyBytes(kTypes, row_count, rows));
    const json calibration = {
        {"FC", {{"radar_extrinsics", Matrix(entry.drive->rig.radars[0].T_vehicle_radar)}}}};
    WriteText(root / (folder + "calibration.json"), calibration.dump());
    WriteText(root / (folder + "ego_motion.json"), MotionOf(entry).dump());
    list["train"].push_back({{"id", entry.id},
                             {"calibration_path", folder + "calibration.json"},
                             {"ego_motion_path", folder + "ego_motion.json"},
                             {"radar_frames",
                              {{"front",
                                {{{"filepath", folder + "radar_front/radar.npy"},
                                  {"time", "2022-03-01T12:00:00"}}}}}}});
  }
  WriteText(root / "trainval-drives-mini.json", list.dump());
}

}  // namespace dcloc
