#include "client/datasets/export_bag.h"

#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client/datasets/files/json_file.h"
#include "client/datasets/rig_file.h"
#include "client/rosbag/bag_writer.h"
#include "client/rosbag/message_types.h"
#include "client/rosbag/message_writer.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVehicleFrame = "base_link";
constexpr const char* kMapFrame = "map";
constexpr std::uint8_t kFloat32 = 7;  // of sensor_msgs/PointField

/// OptionalColumns of a cloud, point by point.
rosbag::PointCloud CloudOf(const Scan& scan, bool has_elevation, bool has_rcs) {
  std::vector<float> x_m;
  std::vector<float> y_m;
  std::vector<float> z_m;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const double elevation = scan.elevation_rad.empty() ? 0.0F : scan.elevation_rad[i];
    const double level_m = scan.range_m[i] * std::cos(elevation);
    x_m.push_back(static_cast<float>(level_m * std::cos(scan.azimuth_rad[i])));
    y_m.push_back(static_cast<float>(level_m * std::sin(scan.azimuth_rad[i])));
    z_m.push_back(static_cast<float>(scan.range_m[i] * std::sin(elevation)));
  }
  std::vector<std::pair<const char*, const std::vector<float>*>> columns = {
      {"x", &x_m},
      {"y", &y_m},
      {"z", &z_m},
      {"range", &scan.range_m},
      {"azimuth", &scan.azimuth_rad},
      {"range_rate", &scan.range_rate_mps}};
  if (has_elevation) columns.emplace_back("elevation", &scan.elevation_rad);
  if (has_rcs) columns.emplace_back("rcs", &scan.rcs_dbsm);
  rosbag::PointCloud cloud{.header = {scan.stamp, scan.radar_id}};
  for (const auto& [name, column] : columns) {
    const auto offset = static_cast<std::uint32_t>(cloud.fields.size() * sizeof(float));
    cloud.fields.push_back({name, offset, kFloat32, 1});
  }
  cloud.point_count = scan.size();
  cloud.point_bytes = columns.size() * sizeof(float);
  for (std::size_t i = 0; i < scan.size(); ++i) {
    for (const auto& [name, column] : columns) {
      cloud.data.append(reinterpret_cast<const char*>(&(*column)[i]), sizeof(float));
    }
  }
  return cloud;
}

std::string Mounts(const Drive& drive, Stamp stamp) {
  std::vector<rosbag::Transform> mounts;
  for (const RadarModel& radar : drive.rig.radars) {
    mounts.push_back({stamp, kVehicleFrame, radar.id, radar.T_vehicle_radar});
  }
  return rosbag::FormatTransforms(mounts);
}

/// The columns that the scans of a radar have, beside those that all have.
struct OptionalColumns {
  bool elevation = false;
  bool rcs = false;
};

/// By radar. FailedPrecondition where one scan has a column that another one of its radar has not,
/// or one that we do not write.
absl::StatusOr<std::map<std::string, OptionalColumns>> OptionalColumnsOf(const Drive& drive) {
  std::map<std::string, OptionalColumns> columns;
  for (const DriveScan& entry : drive.scans) {
    const Scan& scan = entry.scan;
    if (scan.size() == 0) continue;
    const OptionalColumns own{!scan.elevation_rad.empty(), !scan.rcs_dbsm.empty()};
    const OptionalColumns& first = columns.try_emplace(scan.radar_id, own).first->second;
    const bool has_sigmas = !scan.range_sigma_m.empty() || !scan.range_rate_sigma_mps.empty() ||
                            !scan.azimuth_sigma_rad.empty() || !scan.elevation_sigma_rad.empty();
    if (!has_sigmas && own.elevation == first.elevation && own.rcs == first.rcs) continue;
    return absl::FailedPreconditionError(
        absl::StrCat("drive ", drive.name, ", radar ", scan.radar_id, ": its scans have ",
                     has_sigmas ? "sigmas of single targets, which are not written to bags"
                                : "elevations or cross-sections in some scans only"));
  }
  return columns;
}

absl::Status AddScan(const DriveScan& entry, OptionalColumns columns, bool is_new_stamp,
                     bool has_poses, rosbag::BagWriter& bag) {
  const Scan& scan = entry.scan;
  absl::Status status;
  if (is_new_stamp && has_poses) {
    status.Update(bag.Add(
        "/tf", rosbag::kTf2, scan.stamp,
        rosbag::FormatTransforms({{scan.stamp, kMapFrame, kVehicleFrame, entry.T_map_vehicle}})));
  }
  if (is_new_stamp && scan.ego_velocity) {
    status.Update(bag.Add("/vehicle/velocity", rosbag::kTwistWithCovarianceStamped, scan.stamp,
                          rosbag::FormatVelocity({scan.stamp, kVehicleFrame}, *scan.ego_velocity)));
  }
  status.Update(bag.Add(absl::StrCat("/radar/", scan.radar_id, "/points"), rosbag::kPointCloud2,
                        scan.stamp,
                        rosbag::FormatPointCloud(CloudOf(scan, columns.elevation, columns.rcs))));
  return status;
}

/// Under which name a file is written until it is whole.
fs::path PartOf(const fs::path& path) { return path.string() + ".part"; }

/// Gives a file that is whole its name.
absl::Status Commit(const fs::path& part, const fs::path& path) {
  std::error_code error;
  fs::rename(part, path, error);
  if (!error) return absl::OkStatus();
  return absl::ErrnoToStatus(error.value(), absl::StrCat(path.string(), ": cannot be written"));
}

/// FailedPrecondition where the file is there and says something else.
absl::Status CheckRig(const Rig& rig, const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return absl::OkStatus();
  const auto present = ReadJson(path);
  if (!present.ok()) return present.status();
  if (*present == nlohmann::json(RigJson(rig))) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      path.string(), ": describes other radars; put the bag into a folder of its own"));
}

absl::Status WriteRig(const Rig& rig, const fs::path& path) {
  const fs::path part = PartOf(path);
  std::ofstream file(part);
  file << RigJson(rig).dump(2) << "\n";
  file.close();
  if (file) return Commit(part, path);
  return absl::DataLossError(absl::StrCat(path.string(), ": could not be written"));
}

absl::Status WriteBag(const Drive& drive, std::map<std::string, OptionalColumns> columns,
                      const fs::path& path, rosbag::Compression compression) {
  absl::StatusOr<rosbag::BagWriter> bag = rosbag::BagWriter::Create(path, compression);
  if (!bag.ok()) return bag.status();
  std::optional<Stamp> previous;
  for (const DriveScan& entry : drive.scans) {
    const Stamp stamp = entry.scan.stamp;
    absl::Status status;
    if (!previous) status = bag->Add("/tf_static", rosbag::kTf2, stamp, Mounts(drive, stamp));
    status.Update(AddScan(entry, columns[entry.scan.radar_id], previous != stamp,
                          drive.pose_source == PoseSource::kReference, *bag));
    if (!status.ok()) {
      return absl::Status(status.code(), absl::StrCat(path.string(), ": ", status.message()));
    }
    previous = stamp;
  }
  return bag->Close();
}

}  // namespace

absl::Status ExportBag(const Drive& drive, const fs::path& path, rosbag::Compression compression) {
  absl::StatusOr<std::map<std::string, OptionalColumns>> columns = OptionalColumnsOf(drive);
  if (!columns.ok()) return columns.status();
  const fs::path rig_file = path.parent_path() / kRigFileName;
  if (absl::Status status = CheckRig(drive.rig, rig_file); !status.ok()) return status;
  const fs::path part = PartOf(path);
  absl::Status status = WriteBag(drive, *std::move(columns), part, compression);
  if (status.ok()) status = Commit(part, path);
  if (status.ok()) return WriteRig(drive.rig, rig_file);
  std::error_code ignored;
  fs::remove(part, ignored);
  return absl::Status(status.code(),
                      absl::StrReplaceAll(status.message(), {{part.string(), path.string()}}));
}

}  // namespace dcloc
