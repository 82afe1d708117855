#include "client/datasets/zod.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/datasets/bag_contents.h"
#include "client/datasets/files/file_error.h"
#include "client/datasets/files/json_file.h"
#include "client/datasets/files/npy_table.h"
#include "client/datasets/fix_poses.h"
#include "client/datasets/radar_selection.h"
#include "client/datasets/rosbag.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kRadarId = "front";

/// A key as the development kit writes it: in camel case, or as its fields are called.
const json* Find(const json& object, const char* snake, const char* camel) {
  if (!object.is_object()) return nullptr;
  auto found = object.find(snake);
  if (found == object.end()) found = object.find(camel);
  return found == object.end() ? nullptr : &*found;
}

/// What the data set's lists say of a drive.
struct Entry {
  fs::path list;
  json info;
};

absl::StatusOr<std::map<std::string, Entry>> ReadLists(const fs::path& root) {
  std::map<std::string, Entry> entries;
  std::error_code error;
  for (const auto& file : fs::directory_iterator(root, error)) {
    const std::string name = file.path().filename().string();
    const bool is_list = (absl::StartsWith(name, "trainval-sequences-") ||
                          absl::StartsWith(name, "trainval-drives-")) &&
                         file.path().extension() == ".json";
    if (!is_list) continue;
    const absl::StatusOr<json> document = ReadJson(file.path());
    if (!document.ok()) return document.status();
    for (const auto& [split, drives] : document->items()) {
      if (!drives.is_array())
        return FileError(file.path(), absl::StrCat("\"", split, "\" must be an array"));
      for (const json& info : drives) {
        const json* const id = Find(info, "id", "id");
        if (id == nullptr || !id->is_string()) {
          return FileError(file.path(),
                           absl::StrCat("an entry of \"", split, "\" has no text \"id\""));
        }
        entries[id->get<std::string>()] = {file.path(), info};
      }
    }
  }
  return entries;
}

absl::StatusOr<fs::path> PathOf(const Entry& entry, const json* value, const char* key) {
  if (value != nullptr && value->is_string()) return fs::path(value->get<std::string>());
  return FileError(entry.list, absl::StrCat("drive ", entry.info["id"].get<std::string>(),
                                            " has no \"", key, "\""));
}

absl::StatusOr<fs::path> RadarPath(const Entry& entry) {
  const json* const frames = Find(entry.info, "radar_frames", "radarFrames");
  const json* const front = frames == nullptr ? nullptr : Find(*frames, kRadarId, kRadarId);
  const bool is_one = front != nullptr && front->is_array() && front->size() == 1;
  return PathOf(entry, is_one ? Find((*front)[0], "filepath", "filepath") : nullptr,
                "radar_frames: front, with one filepath");
}

/// An array of `rows` times `columns` numbers, row by row.
absl::StatusOr<std::vector<double>> Numbers(const json& value, std::size_t columns) {
  std::vector<double> numbers;
  for (const json& row : value) {
    if (columns == 1 && row.is_number()) {
      numbers.push_back(row.get<double>());
      continue;
    }
    if (!row.is_array() || row.size() != columns) {
      return absl::DataLossError(
          absl::StrCat("row ", numbers.size() / columns, " must have ", columns, " numbers"));
    }
    for (const json& number : row) {
      if (!number.is_number())
        return absl::DataLossError(
            absl::StrCat("row ", numbers.size() / columns, " holds what is no number"));
      numbers.push_back(number.get<double>());
    }
  }
  return numbers;
}

absl::StatusOr<Pose3> PoseOfRows(const double* m) {
  Eigen::Matrix3d R;
  R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  constexpr double kMaxError = 0.01;
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < kMaxError) {
    return Pose3{{m[3], m[7], m[11]}, Eigen::Quaterniond(R).normalized()};
  }
  return absl::DataLossError("its rotation is none");
}

absl::StatusOr<Pose3> ReadMount(const fs::path& path) {
  const absl::StatusOr<json> document = ReadJson(path);
  if (!document.ok()) return document.status();
  const json* const camera = Find(*document, "FC", "FC");
  const json* const mount =
      camera == nullptr ? nullptr : Find(*camera, "radar_extrinsics", "radarExtrinsics");
  if (mount == nullptr || !mount->is_array() || mount->size() != 4) {
    return FileError(path, "has no FC: radar_extrinsics of four rows");
  }
  const auto numbers = Numbers(*mount, 4);
  absl::StatusOr<Pose3> pose =
      numbers.ok() ? PoseOfRows(numbers->data()) : absl::StatusOr<Pose3>(numbers.status());
  if (!pose.ok())
    return FileError(path, absl::StrCat("radar_extrinsics: ", pose.status().message()));
  return pose;
}

/// The columns of ego_motion.json.
struct EgoMotionColumns {
  std::vector<double> stamps_s, poses, velocities, angular_rates;
  GeodeticPosition origin;
};

absl::StatusOr<EgoMotionColumns> ReadColumns(const json& document) {
  EgoMotionColumns columns;
  const auto take = [&](const char* snake, const char* camel, std::size_t count,
                        std::vector<double>& numbers) {
    const json* const value = Find(document, snake, camel);
    if (value == nullptr || !value->is_array())
      return absl::DataLossError(absl::StrCat("has no array \"", snake, "\""));
    json flat = *value;
    if (count == 16) {  // a matrix is four rows
      flat = json::array();
      for (const json& matrix : *value)
        for (const json& row : matrix) flat.push_back(row);
    }
    absl::StatusOr<std::vector<double>> read = Numbers(flat, count == 16 ? 4 : count);
    if (!read.ok())
      return absl::DataLossError(absl::StrCat("\"", snake, "\": ", read.status().message()));
    numbers = *std::move(read);
    if (columns.stamps_s.empty() || numbers.size() == count * columns.stamps_s.size())
      return absl::OkStatus();
    return absl::DataLossError(absl::StrCat("\"", snake, "\" has ", numbers.size() / count,
                                            " rows; \"timestamps\" has ", columns.stamps_s.size()));
  };
  std::vector<double> origin;
  absl::Status status = take("timestamps", "timestamps", 1, columns.stamps_s);
  if (status.ok() && columns.stamps_s.empty())
    status = absl::DataLossError("\"timestamps\" is empty");
  if (status.ok()) status = take("poses", "poses", 16, columns.poses);
  if (status.ok()) status = take("velocities", "velocities", 3, columns.velocities);
  if (status.ok()) status = take("angular_rates", "angularRates", 3, columns.angular_rates);
  if (!status.ok()) return status;
  const json* const place = Find(document, "origin_lat_lon", "originLatLon");
  const auto numbers =
      place == nullptr
          ? absl::StatusOr<std::vector<double>>(absl::DataLossError("has no \"origin_lat_lon\""))
          : Numbers(*place, 1);
  if (!numbers.ok()) return numbers.status();
  if (numbers->size() != 2) return absl::DataLossError("\"origin_lat_lon\" must be two numbers");
  columns.origin = {.latitude_deg = (*numbers)[0], .longitude_deg = (*numbers)[1]};
  if (status = Validate(columns.origin); !status.ok())
    return absl::DataLossError(absl::StrCat("origin_lat_lon: ", status.message()));
  return columns;
}

/// -1 where the turn rates are counted clockwise, as OxTS units do with z down; inferred from the
/// poses.
double TurnSign(const BagContents& contents, const std::vector<double>& angular_rates) {
  double product = 0.0;
  for (std::size_t i = 1; i < contents.references.size(); ++i) {
    const Pose3 step =
        contents.references[i - 1].T_frame_child->Inverse() * *contents.references[i].T_frame_child;
    product += angular_rates[3 * i + 2] * Yaw(step.rotation);
  }
  return product < 0.0 ? -1.0 : 1.0;
}

absl::Status AddMotion(const fs::path& path, BagContents& contents, std::string& note) {
  const absl::StatusOr<json> document = ReadJson(path);
  if (!document.ok()) return document.status();
  const absl::StatusOr<EgoMotionColumns> columns = ReadColumns(*document);
  if (!columns.ok()) return FileError(path, columns.status().message());
  const GeodeticAnchor anchor = SharedAnchor(columns->origin);
  note = AnchorNote(anchor);
  const Eigen::Vector3d p_map_origin = MapFromGeodetic(anchor, columns->origin);
  Stamp previous{};
  for (std::size_t i = 0; i < columns->stamps_s.size(); ++i) {
    if (!(std::abs(columns->stamps_s[i]) <= 4e9)) {
      return FileError(path, absl::StrCat("pose ", i, " has no time: ", columns->stamps_s[i]));
    }
    const Stamp stamp{std::chrono::nanoseconds(std::llround(columns->stamps_s[i] * 1e9))};
    const absl::StatusOr<Pose3> pose = PoseOfRows(&columns->poses[16 * i]);
    if (!pose.ok()) return FileError(path, absl::StrCat("pose ", i, ": ", pose.status().message()));
    if (stamp <= previous)
      return FileError(path,
                       absl::StrCat("\"timestamps\" ", i, " is ", stamp.time_since_epoch().count(),
                                    " ns; it must be after the one before"));
    previous = stamp;
    contents.references.push_back(
        {.header = {stamp, "map"},
         .T_frame_child = Pose3{p_map_origin + pose->translation_m, pose->rotation}});
  }
  const double sign = TurnSign(contents, columns->angular_rates);
  for (std::size_t i = 0; i < columns->stamps_s.size(); ++i) {
    const EgoVelocity velocity{{columns->velocities[3 * i], 0.0, 0.0},
                               {0.0, 0.0, sign * columns->angular_rates[3 * i + 2]},
                               std::nullopt};
    contents.motions.push_back(
        {.header = {contents.references[i].header.stamp, ""}, .velocity = velocity});
  }
  return absl::OkStatus();
}

/// The rows of a radar table that belong to scans.
struct RadarColumns {
  std::vector<std::uint32_t> scan_index;
  std::vector<std::int64_t> timestamp;
  std::vector<float> range, azimuth, elevation, range_rate;
};

absl::StatusOr<RadarColumns> ReadRadar(const fs::path& path) {
  const absl::StatusOr<NpyTable> table = NpyTable::Read(path);
  if (!table.ok()) return table.status();
  RadarColumns columns;
  absl::Status status;
  const auto take = [&]<typename Number>(const char* name, std::vector<Number>& column) {
    absl::StatusOr<std::vector<Number>> values = table->Column<Number>(name);
    status.Update(values.status());
    if (values.ok()) column = *std::move(values);
  };
  take("scan_index", columns.scan_index);
  take("timestamp", columns.timestamp);
  take("radar_range", columns.range);
  take("azimuth_angle", columns.azimuth);
  take("elevation_angle", columns.elevation);
  take("range_rate", columns.range_rate);
  if (!status.ok()) return status;
  return columns;
}

absl::Status AddScans(const fs::path& path, BagContents& contents) {
  const absl::StatusOr<RadarColumns> rows = ReadRadar(path);
  if (!rows.ok()) return rows.status();
  std::vector<Scan>& scans = contents.scans;
  for (std::size_t i = 0; i < rows->timestamp.size(); ++i) {
    const Stamp stamp{std::chrono::nanoseconds(rows->timestamp[i])};
    const bool is_new = i == 0 || rows->scan_index[i] != rows->scan_index[i - 1];
    if (is_new ? !scans.empty() && stamp <= scans.back().stamp : stamp != scans.back().stamp) {
      return FileError(path,
                       absl::StrCat("field \"timestamp\" of row ", i, " is ", rows->timestamp[i],
                                    is_new ? "; a scan must be after the one before"
                                           : "; it must be that of its scan",
                                    ", ", scans.back().stamp.time_since_epoch().count()));
    }
    if (is_new) {
      scans.emplace_back();
      scans.back().stamp = stamp;
      scans.back().radar_id = kRadarId;
    }
    const bool is_finite = std::isfinite(rows->range[i]) && rows->range[i] > 0.0F &&
                           std::isfinite(rows->azimuth[i]) && std::isfinite(rows->elevation[i]) &&
                           std::isfinite(rows->range_rate[i]);
    if (!is_finite) continue;
    scans.back().range_m.push_back(rows->range[i]);
    scans.back().azimuth_rad.push_back(rows->azimuth[i]);
    scans.back().elevation_rad.push_back(rows->elevation[i]);
    scans.back().range_rate_mps.push_back(rows->range_rate[i]);
  }
  for (const Scan& scan : scans) {
    if (absl::Status status = Validate(scan); !status.ok()) {
      return FileError(path, absl::StrCat("the scan at ", scan.stamp.time_since_epoch().count(),
                                          " ns: ", status.message()));
    }
  }
  return absl::OkStatus();
}

BagMapping MappingOf(const Pose3& T_vehicle_radar) {
  BagMapping mapping;
  mapping.radars.push_back({.id = kRadarId,
                            .topic = "radar_front",
                            .range = "radar_range",
                            .azimuth = "azimuth_angle",
                            .elevation = "elevation_angle"});
  mapping.radars.back().T_vehicle_radar = T_vehicle_radar;
  mapping.vehicle_frame = "ego";
  mapping.motion_topic = "ego_motion.json";
  return mapping;
}

absl::StatusOr<Drive> ReadEntry(const fs::path& root, const Entry& entry,
                                const DriveRequest& request) {
  const auto calibration =
      PathOf(entry, Find(entry.info, "calibration_path", "calibrationPath"), "calibration_path");
  if (!calibration.ok()) return calibration.status();
  const auto motion =
      PathOf(entry, Find(entry.info, "ego_motion_path", "egoMotionPath"), "ego_motion_path");
  if (!motion.ok()) return motion.status();
  const auto radar = RadarPath(entry);
  if (!radar.ok()) return radar.status();
  const absl::StatusOr<Pose3> mount = ReadMount(root / *calibration);
  if (!mount.ok()) return mount.status();
  BagContents contents;
  contents.summary.has_index = true;
  std::string note;
  absl::Status status = AddMotion(root / *motion, contents, note);
  if (status.ok()) status = AddScans(root / *radar, contents);
  if (!status.ok()) return status;
  absl::StatusOr<Drive> drive = DriveOf(request.name, (root / *radar).parent_path(),
                                        std::move(contents), MappingOf(*mount), request);
  if (!drive.ok()) return FileError(root / *radar, drive.status().message());
  drive->notes.push_back(std::move(note));
  return drive;
}

}  // namespace

std::vector<std::string> ZodDrives(const fs::path& root) {
  std::vector<std::string> names;
  const auto entries = ReadLists(root);
  if (!entries.ok()) return names;
  for (const auto& [id, entry] : *entries) names.push_back(id);
  return names;
}

absl::StatusOr<Drive> ReadZodDrive(const fs::path& root, const DriveRequest& request) {
  if (absl::Status status = CheckRadars(request.radars, {kRadarId}); !status.ok()) return status;
  const auto entries = ReadLists(root);
  if (!entries.ok()) return entries.status();
  const auto entry = entries->find(request.name);
  if (entry != entries->end()) return ReadEntry(root, entry->second, request);
  const std::vector<std::string> names = ZodDrives(root);
  return absl::NotFoundError(absl::StrCat(root.string(), ": there is no drive \"", request.name,
                                          "\" in trainval-*.json; the drives are ",
                                          names.empty() ? "none" : absl::StrJoin(names, ", ")));
}

}  // namespace dcloc
