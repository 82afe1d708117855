#include "client/trajectory/trajectory_writer.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "absl/time/time.h"
#include "core/geometry/geodetic_heading.h"

namespace dcloc {
namespace {

std::int64_t Nanoseconds(Stamp stamp) { return stamp.time_since_epoch().count(); }

std::string TimeText(Stamp stamp) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%E9SZ", absl::FromUnixNanos(Nanoseconds(stamp)),
                          absl::UTCTimeZone());
}

void AppendPose(std::string& line, const Pose3& pose, char separator) {
  const Eigen::Vector3d& t = pose.translation_m;
  const Eigen::Quaterniond& q = pose.rotation;
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) {
    absl::StrAppendFormat(&line, "%c%.17g", separator, value);
  }
}

std::string Tum(const Trajectory& trajectory) {
  std::string text;
  for (const TrajectoryPose& entry : trajectory.poses) text += TumLine(entry);
  return text;
}

std::string Kitti(const Trajectory& trajectory) {
  std::string text;
  for (const TrajectoryPose& entry : trajectory.poses) {
    const Eigen::Matrix3d rotation = entry.T_map_vehicle.Rotation();
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (Eigen::Index column = 0; column < 4; ++column) {
        const double value =
            column < 3 ? rotation(row, column) : entry.T_map_vehicle.translation_m(row);
        absl::StrAppendFormat(&text, "%s%.17g", row + column == 0 ? "" : " ", value);
      }
    }
    text += '\n';
  }
  return text;
}

std::string Csv(const Trajectory& trajectory) {
  std::string text = "stamp_ns,x_m,y_m,z_m,qx,qy,qz,qw";
  if (trajectory.anchor) text += ",latitude_deg,longitude_deg,height_m,heading_deg";
  text += '\n';
  for (const auto& [stamp, pose] : trajectory.poses) {
    absl::StrAppend(&text, Nanoseconds(stamp));
    AppendPose(text, pose, ',');
    if (trajectory.anchor) {
      const GeodeticPosition p = GeodeticFromMap(*trajectory.anchor, pose.translation_m);
      absl::StrAppendFormat(&text, ",%.9f,%.9f,%.4f,%.5f", p.latitude_deg, p.longitude_deg,
                            p.height_m, HeadingFromMap(*trajectory.anchor, pose));
    }
    text += '\n';
  }
  return text;
}

std::string GeoJson(const Trajectory& trajectory) {
  using Json = nlohmann::ordered_json;
  // As text, so that coordinates have the decimals that mean something.
  std::string coordinates;
  Json times = Json::array();
  for (const auto& [stamp, pose] : trajectory.poses) {
    const GeodeticPosition p = GeodeticFromMap(*trajectory.anchor, pose.translation_m);
    absl::StrAppendFormat(&coordinates, "%s[%.9f,%.9f,%.4f]", coordinates.empty() ? "" : ",",
                          p.longitude_deg, p.latitude_deg, p.height_m);
    times.push_back(TimeText(stamp));
  }
  const Json properties = {{"name", trajectory.name}, {"coordTimes", times}};
  // A line string has two positions at least.
  const bool is_line = trajectory.poses.size() > 1;
  const std::string geometry =
      trajectory.poses.empty()
          ? "null"
          : absl::StrCat(R"({"type":")", is_line ? "LineString" : "Point", R"(","coordinates":)",
                         is_line ? "[" : "", coordinates, is_line ? "]" : "", "}");
  return absl::StrCat(R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":)",
                      properties.dump(-1, ' ', false, Json::error_handler_t::replace),
                      R"(,"geometry":)", geometry, "}]}\n");
}

std::string Gpx(const Trajectory& trajectory) {
  std::string text = absl::StrCat(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<gpx version=\"1.1\" creator=\"dcloc\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n"
      "<trk><name>",
      absl::StrReplaceAll(trajectory.name, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}}),
      "</name><trkseg>\n");
  for (const auto& [stamp, pose] : trajectory.poses) {
    const GeodeticPosition p = GeodeticFromMap(*trajectory.anchor, pose.translation_m);
    absl::StrAppendFormat(
        &text, "<trkpt lat=\"%.9f\" lon=\"%.9f\"><ele>%.4f</ele><time>%s</time></trkpt>\n",
        p.latitude_deg, p.longitude_deg, p.height_m, TimeText(stamp));
  }
  return text + "</trkseg></trk>\n</gpx>\n";
}

}  // namespace

std::string TumLine(const TrajectoryPose& entry) {
  constexpr std::int64_t kPerSecond = 1'000'000'000;
  // Not through a double, which does not hold the nanoseconds of today.
  const std::int64_t stamp_ns = Nanoseconds(entry.stamp);
  std::string line = absl::StrFormat("%d.%09d", stamp_ns / kPerSecond, stamp_ns % kPerSecond);
  AppendPose(line, entry.T_map_vehicle, ' ');
  return line + "\n";
}

absl::StatusOr<std::string> FormatTrajectory(const Trajectory& trajectory,
                                             TrajectoryFormat format) {
  if (NeedsAnchor(format) && !trajectory.anchor) {
    return absl::FailedPreconditionError(absl::StrCat(
        "trajectory ", trajectory.name,
        ": this format has places on the Earth, and the map has no anchor; write tum, kitti or csv,"
        " or give the map an anchor"));
  }
  switch (format) {
    case TrajectoryFormat::kTum:
      return Tum(trajectory);
    case TrajectoryFormat::kKitti:
      return Kitti(trajectory);
    case TrajectoryFormat::kCsv:
      return Csv(trajectory);
    case TrajectoryFormat::kGeoJson:
      return GeoJson(trajectory);
    case TrajectoryFormat::kGpx:
      return Gpx(trajectory);
  }
  return absl::InvalidArgumentError("trajectory format is none of TrajectoryFormat");
}

}  // namespace dcloc
