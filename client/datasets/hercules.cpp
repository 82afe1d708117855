#include "client/datasets/hercules.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "client/datasets/bag_contents.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/paths_below.h"
#include "client/datasets/files/stamped_rows.h"
#include "client/datasets/radar_selection.h"
#include "client/datasets/rosbag.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRadarId = "continental";
constexpr std::size_t kRecordBytes = 29;  // x y z v r, cross-section, azimuth, elevation

/// Files by the stamp that is their name.
using ScanFiles = std::map<Stamp, fs::path>;

absl::StatusOr<fs::path> RadarFolder(const fs::path& sequence) {
  constexpr std::array kNames = {"Radar/Continental", "radar/continental", "Continental",
                                 "continental"};
  std::error_code error;
  for (const char* const name : kNames) {
    if (fs::is_directory(sequence / name, error)) return sequence / name;
  }
  return absl::NotFoundError(absl::StrCat(sequence.string(), ": there is no folder ",
                                          absl::StrJoin(kNames, ", "), " of the radar"));
}

absl::StatusOr<Stamp> StampOfName(absl::string_view name) {
  std::int64_t nanoseconds = 0;
  if (absl::SimpleAtoi(name, &nanoseconds) && nanoseconds >= 0) {
    return Stamp(std::chrono::nanoseconds(nanoseconds));
  }
  return absl::DataLossError(
      absl::StrCat("the stamp is '", name, "'; it must be a number of nanoseconds"));
}

absl::StatusOr<ScanFiles> FilesOf(const fs::path& folder) {
  ScanFiles files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() != ".bin") continue;
    const absl::StatusOr<Stamp> stamp = StampOfName(entry.path().stem().string());
    if (!stamp.ok()) return FileError(entry.path(), stamp.status().message());
    files[*stamp] = entry.path();
  }
  if (files.empty()) return absl::NotFoundError(absl::StrCat(folder.string(), ": holds no scan"));
  return files;
}

/// NotFound where the list of what was recorded has a scan that is not there, DataLoss where its
/// stamps go back.
absl::Status CheckAllThere(const fs::path& list, const fs::path& folder, const ScanFiles& files) {
  std::error_code error;
  if (!fs::exists(list, error)) return absl::OkStatus();
  std::ifstream file(list);
  if (!file) return CannotOpen(list);
  Stamp previous{};
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    const std::vector<absl::string_view> cells =
        absl::StrSplit(line, absl::ByAnyChar(", \t\r"), absl::SkipEmpty());
    if (cells.size() < 2 || cells[1] != kRadarId) continue;
    absl::StatusOr<Stamp> stamp = StampOfName(cells[0]);
    if (stamp.ok() && *stamp <= previous) {
      stamp = absl::DataLossError(
          absl::StrCat("the stamp is ", cells[0], " ns; it must be after the one before"));
    }
    if (!stamp.ok()) {
      return FileError(list, absl::StrCat("line ", number, ": ", stamp.status().message()));
    }
    previous = *stamp;
    if (files.contains(*stamp)) continue;
    return absl::NotFoundError(absl::StrCat((folder / std::string(cells[0])).string(),
                                            ".bin: there is no such file; ", list.string(),
                                            ", line ", number, ", has its scan"));
  }
  return absl::OkStatus();
}

float FloatAt(const std::string& bytes, std::size_t offset) {
  float value = 0.0F;
  std::memcpy(&value, bytes.data() + offset, sizeof(float));
  return value;
}

absl::StatusOr<Scan> ReadScan(Stamp stamp, const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return CannotOpen(path);
  const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (bytes.size() % kRecordBytes != 0) {
    return FileError(path,
                     absl::StrCat("has ", bytes.size(), " bytes; records have ", kRecordBytes,
                                  ", so that record ", bytes.size() / kRecordBytes, " is cut off"));
  }
  Scan scan;
  scan.stamp = stamp;
  scan.radar_id = kRadarId;
  for (std::size_t at = 0; at < bytes.size(); at += kRecordBytes) {
    const double x = FloatAt(bytes, at);
    const double y = FloatAt(bytes, at + 4);
    const double z = FloatAt(bytes, at + 8);
    const double range_m = std::hypot(x, y, z);
    const float range_rate_mps = FloatAt(bytes, at + 12);
    if (!std::isfinite(range_m) || !std::isfinite(range_rate_mps) || range_m == 0.0) continue;
    scan.range_m.push_back(static_cast<float>(range_m));
    scan.azimuth_rad.push_back(static_cast<float>(std::atan2(y, x)));
    scan.elevation_rad.push_back(static_cast<float>(std::atan2(z, std::hypot(x, y))));
    scan.range_rate_mps.push_back(range_rate_mps);
    scan.rcs_dbsm.push_back(static_cast<float>(static_cast<std::int8_t>(bytes[at + 20])));
  }
  if (absl::Status status = Validate(scan); !status.ok()) {
    return FileError(path, status.message());
  }
  return scan;
}

/// The three upper rows of a transform, after `key` and a colon.
absl::StatusOr<Pose3> ReadTransform(const fs::path& path, absl::string_view key) {
  constexpr std::size_t kNumbers = 12;
  std::ifstream file(path);
  if (!file) return CannotOpen(path);
  std::string line;
  while (std::getline(file, line)) {
    const std::pair<absl::string_view, absl::string_view> parts =
        absl::StrSplit(line, absl::MaxSplits(':', 1));
    if (absl::StripAsciiWhitespace(parts.first) != key) continue;
    const std::vector<absl::string_view> cells =
        absl::StrSplit(parts.second, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    std::array<double, kNumbers> m{};
    bool is_read = cells.size() == kNumbers;
    for (std::size_t i = 0; i < kNumbers && is_read; ++i)
      is_read = absl::SimpleAtod(cells[i], &m[i]);
    Eigen::Matrix3d R;
    R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    constexpr double kMaxError = 0.01;
    if (is_read && (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < kMaxError) {
      return Pose3{{m[3], m[7], m[11]}, Eigen::Quaterniond(R).normalized()};
    }
    return FileError(
        path, absl::StrCat(key, " must be three rows of a rotation and a translation; it is \"",
                           parts.second, "\""));
  }
  return FileError(path, absl::StrCat("has no ", key));
}

/// Of the sequence, or of a folder above it up to the data set's.
absl::StatusOr<Pose3> ReadMount(const fs::path& root, const std::string& name) {
  std::error_code error;
  fs::path folder = root / name;
  for (const fs::path& part : fs::path(name)) {
    if (part.empty() || fs::is_directory(folder / "Calibration", error)) break;
    folder = folder.parent_path();
  }
  const fs::path calibration = folder / "Calibration";
  const auto T_radar_lidar =
      ReadTransform(calibration / "Continental_LiDAR.txt", "Tr_lidar_to_radar");
  if (!T_radar_lidar.ok()) return T_radar_lidar.status();
  const auto T_imu_lidar = ReadTransform(calibration / "IMU_LiDAR.txt", "Tr_lidar_to_imu");
  if (!T_imu_lidar.ok()) return T_imu_lidar.status();
  return *T_imu_lidar * T_radar_lidar->Inverse();
}

absl::Status AddTurnRates(const fs::path& path, BagContents& contents) {
  constexpr std::array kColumns = {"q_x",   "q_y",   "q_z",   "q_w",   "eul_x",
                                   "eul_y", "eul_z", "gyr_x", "gyr_y", "gyr_z"};
  const auto rows = ReadStampedRows(path, StampUnit::kNanoseconds, kColumns);
  if (!rows.ok()) return rows.status();
  for (const StampedRow& row : *rows) {
    contents.turn_rates.push_back({{row.stamp, ""}, {row.values[7], row.values[8], row.values[9]}});
  }
  return absl::OkStatus();
}

absl::Status AddPoses(const fs::path& path, BagContents& contents) {
  const auto poses = ReadStampedPoses(path, StampUnit::kNanoseconds);
  if (!poses.ok()) return poses.status();
  for (const StampedPose& pose : *poses) {
    contents.references.push_back({{pose.stamp, "map"}, "", pose.pose, std::nullopt});
  }
  return absl::OkStatus();
}

absl::Status AddScans(const fs::path& sequence, BagContents& contents) {
  const absl::StatusOr<fs::path> folder = RadarFolder(sequence);
  if (!folder.ok()) return folder.status();
  const absl::StatusOr<ScanFiles> files = FilesOf(*folder);
  if (!files.ok()) return files.status();
  const fs::path list = sequence / "sensor_data" / "data_stamp.csv";
  if (absl::Status status = CheckAllThere(list, *folder, *files); !status.ok()) return status;
  for (const auto& [stamp, path] : *files) {
    absl::StatusOr<Scan> scan = ReadScan(stamp, path);
    if (!scan.ok()) return scan.status();
    contents.scans.push_back(*std::move(scan));
  }
  return absl::OkStatus();
}

BagMapping MappingOf(const Pose3& T_vehicle_radar) {
  BagMapping mapping;
  mapping.radars.push_back({.id = kRadarId, .topic = kRadarId, .x = "x", .y = "y", .z = "z"});
  mapping.radars.back().T_vehicle_radar = T_vehicle_radar;
  mapping.vehicle_frame = "imu";
  mapping.velocity_by_doppler = true;
  mapping.imu_topic = "imu";
  mapping.T_vehicle_imu = Pose3();
  mapping.T_vehicle_reference = T_vehicle_radar;  // the poses are the radar's
  return mapping;
}

}  // namespace

std::vector<std::string> HerculesSequences(const fs::path& root) {
  const std::vector<fs::path> sequences = PathsBelow(root, [](const fs::path& path) {
    std::error_code ignored;
    return fs::exists(path / "PR_GT" / "Continental_gt.txt", ignored);
  });
  std::vector<std::string> names;
  for (const fs::path& sequence : sequences) names.push_back(sequence.generic_string());
  std::ranges::sort(names);
  return names;
}

absl::StatusOr<Drive> ReadHerculesDrive(const fs::path& root, const DriveRequest& request) {
  if (absl::Status status = CheckRadars(request.radars, {kRadarId}); !status.ok()) return status;
  const std::vector<std::string> names = HerculesSequences(root);
  if (std::ranges::find(names, request.name) == names.end()) {
    return absl::NotFoundError(absl::StrCat(root.string(), ": there is no sequence \"",
                                            request.name,
                                            "\" with PR_GT/Continental_gt.txt; the "
                                            "sequences are ",
                                            names.empty() ? "none" : absl::StrJoin(names, ", ")));
  }
  const fs::path sequence = root / request.name;
  const absl::StatusOr<Pose3> mount = ReadMount(root, request.name);
  if (!mount.ok()) return mount.status();
  BagContents contents;
  contents.summary.has_index = true;
  absl::Status status = AddScans(sequence, contents);
  if (status.ok()) status = AddTurnRates(sequence / "sensor_data" / "xsens_imu.csv", contents);
  if (status.ok()) status = AddPoses(sequence / "PR_GT" / "Continental_gt.txt", contents);
  if (!status.ok()) return status;
  absl::StatusOr<Drive> drive =
      DriveOf(request.name, sequence, std::move(contents), MappingOf(*mount), request);
  if (!drive.ok()) return FileError(sequence, drive.status().message());
  return drive;
}

}  // namespace dcloc
