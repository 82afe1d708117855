#include "tests/client/datasets/bag_set_writer.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/rosbag/bag_bytes.h"
#include "client/rosbag/bag_writer.h"
#include "client/rosbag/message_writer.h"
#include "core/geometry/degrees.h"
#include "core/geometry/geodetic_anchor.h"
#include "tests/client/datasets/body_frame.h"

namespace dcloc {
namespace {

using rosbag::AppendNumber;
using rosbag::AppendText;
using Columns = std::vector<std::pair<const char*, std::vector<float>>>;

constexpr std::uint8_t kFloat32 = 7;

Pose3 Turned(const Eigen::Vector3d& translation_m, double yaw_deg, double pitch_deg) {
  return {translation_m, Eigen::AngleAxisd(yaw_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(pitch_deg * kRadPerDeg, Eigen::Vector3d::UnitY())};
}

Columns ColumnsOf(const Scan& scan, const char* range_rate) {
  Columns columns = {{"x", {}}, {"y", {}}, {"z", {}}, {range_rate, scan.range_rate_mps}};
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double azimuth = scan.azimuth_rad[i];
    const double elevation = scan.elevation_rad[i];
    const double level_m = scan.range_m[i] * std::cos(elevation);
    columns[0].second.push_back(static_cast<float>(level_m * std::cos(azimuth)));
    columns[1].second.push_back(static_cast<float>(level_m * std::sin(azimuth)));
    columns[2].second.push_back(static_cast<float>(scan.range_m[i] * std::sin(elevation)));
  }
  return columns;
}

std::string HeaderBytes(Stamp stamp, const char* frame) {
  std::string bytes;
  AppendNumber(bytes, std::uint32_t{0});
  rosbag::AppendTime(bytes, stamp);
  AppendText(bytes, frame);
  return bytes;
}

std::string Cloud2(Stamp stamp, const Columns& columns, const char* frame) {
  rosbag::PointCloud cloud;
  cloud.header = {stamp, frame};
  cloud.point_count = columns[0].second.size();
  cloud.point_bytes = columns.size() * sizeof(float);
  for (const auto& [name, values] : columns) {
    cloud.fields.push_back(
        {name, static_cast<std::uint32_t>(4 * cloud.fields.size()), kFloat32, 1});
  }
  for (std::size_t i = 0; i < cloud.point_count; ++i) {
    for (const auto& [name, values] : columns) AppendNumber(cloud.data, values[i]);
  }
  return rosbag::FormatPointCloud(cloud);
}

/// sensor_msgs/PointCloud: points, then a channel for each other column.
std::string CloudWithChannels(Stamp stamp, const Columns& columns, const char* frame) {
  std::string bytes = HeaderBytes(stamp, frame);
  const std::size_t count = columns[0].second.size();
  AppendNumber(bytes, static_cast<std::uint32_t>(count));
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) AppendNumber(bytes, columns[axis].second[i]);
  }
  AppendNumber(bytes, static_cast<std::uint32_t>(columns.size() - 3));
  for (std::size_t c = 3; c < columns.size(); ++c) {
    AppendText(bytes, columns[c].first);
    AppendNumber(bytes, static_cast<std::uint32_t>(count));
    for (const float value : columns[c].second) AppendNumber(bytes, value);
  }
  return bytes;
}

void AppendZeros(std::string& bytes, int count) {
  for (int i = 0; i < count; ++i) AppendNumber(bytes, 0.0);
}

std::string Imu(Stamp stamp, const Eigen::Vector3d& angular_radps) {
  std::string bytes = HeaderBytes(stamp, "imu");
  AppendZeros(bytes, 4 + 9);
  for (const double value : angular_radps) AppendNumber(bytes, value);
  AppendZeros(bytes, 9 + 3 + 9);
  return bytes;
}

std::string Fix(Stamp stamp, const GeodeticPosition& position) {
  std::string bytes = HeaderBytes(stamp, "gps");
  AppendNumber(bytes, std::int8_t{0});
  AppendNumber(bytes, std::uint16_t{1});
  AppendNumber(bytes, position.latitude_deg);
  AppendNumber(bytes, position.longitude_deg);
  AppendNumber(bytes, position.height_m);
  AppendZeros(bytes, 9);
  AppendNumber(bytes, std::uint8_t{0});
  return bytes;
}

/// The frames of a set: its body on the drive's vehicle, and the frame of its poses on the body.
struct Frames {
  Pose3 T_vehicle_body;
  Pose3 T_body_reference;
};

Frames FramesOf(BagSet set, const Drive& drive) {
  if (set == BagSet::kMscRad4r) return {};
  const Pose3 T_body_reference =
      set == BagSet::kSnailRadar ? Turned(Eigen::Vector3d::Zero(), 90.0, 0.0) : Pose3();
  return {BodyOnVehicle(drive, MountInSet(set)), T_body_reference};
}

std::string PoseLine(Stamp stamp, const Pose3& pose) {
  const std::int64_t ns = stamp.time_since_epoch().count();
  const Eigen::Vector3d& t = pose.translation_m;
  const Eigen::Quaterniond& q = pose.rotation;
  return absl::StrFormat("%d.%09d %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", ns / 1'000'000'000,
                         ns % 1'000'000'000, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

absl::Status AddCloud(BagSet set, const Scan& scan, rosbag::BagWriter& bag) {
  switch (set) {
    case BagSet::kSnailRadar:
      return bag.Add("/ars548", rosbag::kPointCloud2, scan.stamp,
                     Cloud2(scan.stamp, ColumnsOf(scan, "doppler"), "ars548"));
    case BagSet::kNtu4dRadLm:
      return bag.Add("/radar_enhanced_pcl", rosbag::kPointCloud, scan.stamp,
                     CloudWithChannels(scan.stamp, ColumnsOf(scan, "Doppler"), "radar"));
    case BagSet::kMscRad4r:
      return bag.Add("/oculii_radar/point_cloud", rosbag::kPointCloud2, scan.stamp,
                     Cloud2(scan.stamp, ColumnsOf(scan, "doppler"), "oculii"));
  }
  return absl::OkStatus();
}

const char* ImuTopic(BagSet set) {
  if (set == BagSet::kSnailRadar) return "/x36d/imu_raw";
  return set == BagSet::kNtu4dRadLm ? "/livox/imu" : "/imu/data";
}

}  // namespace

Pose3 MountInSet(BagSet set) {
  if (set == BagSet::kSnailRadar) return Turned({0.0, 0.0, 0.07}, -3.0, -1.0);
  if (set == BagSet::kMscRad4r) return Pose3();
  Eigen::Matrix3d R;
  R << 0.998742, -0.021546, 0.045280, 0.020570, 0.999549, 0.021905, -0.045731, -0.020946, 0.998734;
  return {{0.2960, -0.1299, -0.0045}, Eigen::Quaterniond(R).normalized()};
}

void WriteBagSet(BagSet set, const Drive& drive, const std::filesystem::path& root,
                 const std::string& name) {
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 36.25, .longitude_deg = 127.25}};
  const std::filesystem::path path = root / (name + ".bag");
  std::filesystem::create_directories(path.parent_path());
  absl::StatusOr<rosbag::BagWriter> bag =
      rosbag::BagWriter::Create(path, rosbag::Compression::kNone);
  const Frames frames = FramesOf(set, drive);
  std::string poses;
  for (const DriveScan& entry : drive.scans) {
    const Stamp stamp = entry.scan.stamp;
    const Pose3 T_map_reference =
        entry.T_map_vehicle * frames.T_vehicle_body * frames.T_body_reference;
    poses += PoseLine(stamp, T_map_reference);
    absl::Status status = AddCloud(set, entry.scan, *bag);
    status.Update(bag->Add(ImuTopic(set), rosbag::kImu, stamp,
                           Imu(stamp, frames.T_vehicle_body.rotation.conjugate() *
                                          entry.scan.ego_velocity->angular_radps)));
    if (set == BagSet::kMscRad4r) {
      status.Update(bag->Add("/fix", rosbag::kNavSatFix, stamp,
                             Fix(stamp, GeodeticFromMap(anchor, T_map_reference.translation_m))));
    }
    if (!status.ok()) throw std::runtime_error(status.ToString());
  }
  if (!bag->Close().ok()) throw std::runtime_error("the bag was not written");
  if (set == BagSet::kMscRad4r) return;
  const std::filesystem::path file = set == BagSet::kSnailRadar
                                         ? root / "ref_trajs_all" / name / "tls_T_xt32.txt"
                                         : path.parent_path() / "gt_odom.txt";
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << poses;
}

}  // namespace dcloc
