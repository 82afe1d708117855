#include "tests/client/datasets/hercules_writer.h"

#include <cmath>
#include <cstdint>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/rosbag/bag_bytes.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;
using rosbag::AppendNumber;

void WriteFileOf(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string Records(const Scan& scan) {
  std::string bytes;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double azimuth = scan.azimuth_rad[i];
    const double elevation = scan.elevation_rad[i];
    const double level_m = scan.range_m[i] * std::cos(elevation);
    AppendNumber(bytes, static_cast<float>(level_m * std::cos(azimuth)));
    AppendNumber(bytes, static_cast<float>(level_m * std::sin(azimuth)));
    AppendNumber(bytes, static_cast<float>(scan.range_m[i] * std::sin(elevation)));
    AppendNumber(bytes, scan.range_rate_mps[i]);
    AppendNumber(bytes, scan.range_m[i]);
    AppendNumber(bytes, static_cast<std::int8_t>(std::lround(scan.rcs_dbsm[i])));
    AppendNumber(bytes, scan.azimuth_rad[i]);
    AppendNumber(bytes, scan.elevation_rad[i]);
  }
  return bytes;
}

std::string Rows(const Pose3& pose) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      absl::StrAppendFormat(&text, " %.12f", pose.Rotation()(row, column));
    }
    absl::StrAppendFormat(&text, " %.12f", pose.translation_m[row]);
  }
  return text;
}

}  // namespace

void WriteHercules(const Drive& drive, const fs::path& root, const std::string& name) {
  const fs::path sequence = root / name;
  const Pose3& T_vehicle_radar = drive.rig.radars[0].T_vehicle_radar;
  std::string list;
  std::string imu;
  std::string poses;
  for (const DriveScan& entry : drive.scans) {
    const std::int64_t ns = entry.scan.stamp.time_since_epoch().count();
    absl::StrAppend(&list, ns, ",imu\n", ns, ",continental\n");
    const Eigen::Vector3d& turn = entry.scan.ego_velocity->angular_radps;
    absl::StrAppendFormat(&imu, "%d,0,0,0,1,0,0,0,%.12f,%.12f,%.12f,0,0,9.8,0,0,0\n", ns, turn.x(),
                          turn.y(), turn.z());
    const Pose3 pose = entry.T_map_vehicle * T_vehicle_radar;
    const Eigen::Vector3d& t = pose.translation_m;
    const Eigen::Quaterniond& q = pose.rotation;
    absl::StrAppendFormat(&poses, "%d %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", ns, t.x(), t.y(),
                          t.z(), q.x(), q.y(), q.z(), q.w());
    WriteFileOf(sequence / "Radar" / "Continental" / absl::StrCat(ns, ".bin"), Records(entry.scan));
  }
  WriteFileOf(sequence / "sensor_data" / "data_stamp.csv", list);
  WriteFileOf(sequence / "sensor_data" / "xsens_imu.csv", imu);
  WriteFileOf(sequence / "PR_GT" / "Continental_gt.txt", poses);
  // A lidar above the IMU, and so before and below the radar.
  const Pose3 T_imu_lidar{{0.1, 0.0, 0.9}, Eigen::Quaterniond::Identity()};
  WriteFileOf(sequence / "Calibration" / "IMU_LiDAR.txt",
              absl::StrCat("# extrinsics\nTr_lidar_to_imu:", Rows(T_imu_lidar), "\n"));
  WriteFileOf(
      sequence / "Calibration" / "Continental_LiDAR.txt",
      absl::StrCat("Tr_lidar_to_radar:", Rows(T_vehicle_radar.Inverse() * T_imu_lidar), "\n"));
}

}  // namespace dcloc
