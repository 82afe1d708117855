#include "client/datasets/fix_poses.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc {
namespace {

constexpr double kStep_m =
    1.0;  // between way points, so that noise of centimetres turns them little

struct Position {
  Stamp stamp;
  Eigen::Vector3d p_map;
};

/// A point of the path, and its direction there.
struct WayPoint {
  Position at;
  double yaw_rad = 0.0;
};

std::vector<WayPoint> WayOf(const std::vector<Position>& positions) {
  std::vector<WayPoint> way;
  for (const Position& position : positions) {
    const bool is_next =
        way.empty() || (position.p_map - way.back().at.p_map).head<2>().norm() >= kStep_m;
    if (is_next) way.push_back({position});
  }
  for (std::size_t i = 0; i < way.size(); ++i) {
    const Eigen::Vector3d& before = way[i == 0 ? 0 : i - 1].at.p_map;
    const Eigen::Vector3d& after = way[std::min(i + 1, way.size() - 1)].at.p_map;
    way[i].yaw_rad = std::atan2(after.y() - before.y(), after.x() - before.x());
  }
  return way;
}

/// Between the waypoints around it, by the time.
double YawAt(Stamp stamp, const std::vector<WayPoint>& way) {
  const auto after = std::ranges::upper_bound(way, stamp, {},
                                              [](const WayPoint& point) { return point.at.stamp; });
  if (after == way.begin()) return way.front().yaw_rad;
  if (after == way.end()) return way.back().yaw_rad;
  const WayPoint& before = *std::prev(after);
  const double share =
      SecondsOf(stamp - before.at.stamp) / SecondsOf(after->at.stamp - before.at.stamp);
  return before.yaw_rad + share * WrapAngle(after->yaw_rad - before.yaw_rad);
}

}  // namespace

GeodeticAnchor SharedAnchor(const GeodeticPosition& position) {
  const auto quarter = [](double degrees) { return std::round(4.0 * degrees) / 4.0; };
  return {.origin = {.latitude_deg = quarter(position.latitude_deg),
                     .longitude_deg = quarter(position.longitude_deg)}};
}

std::string AnchorNote(const GeodeticAnchor& anchor) {
  return absl::StrFormat("its frame lies at latitude %.2f, longitude %.2f degrees, x to the east",
                         anchor.origin.latitude_deg, anchor.origin.longitude_deg);
}

absl::Status AddPosesOfFixes(BagContents& contents, std::vector<std::string>& notes) {
  std::vector<Position> positions;
  GeodeticAnchor anchor;
  for (const rosbag::SatelliteFix& fix : contents.fixes) {
    if (!fix.has_fix) continue;
    const GeodeticPosition position{fix.latitude_deg, fix.longitude_deg, fix.height_m};
    if (absl::Status status = Validate(position); !status.ok()) return status;
    if (positions.empty()) anchor = SharedAnchor(position);
    positions.push_back({fix.header.stamp, MapFromGeodetic(anchor, position)});
  }
  const std::vector<WayPoint> way = WayOf(positions);
  if (way.size() < 2) {
    return absl::InvalidArgumentError(absl::StrCat("of ", contents.fixes.size(),
                                                   " satellite fixes no two are valid and ",
                                                   kStep_m, " m apart; a heading needs them"));
  }
  for (const Position& position : positions) {
    const Pose3 pose{position.p_map, Eigen::Quaterniond(Eigen::AngleAxisd(
                                         YawAt(position.stamp, way), Eigen::Vector3d::UnitZ()))};
    contents.references.push_back({{position.stamp, ""}, "", pose, std::nullopt});
  }
  notes.push_back(absl::StrCat("its poses are satellite fixes, level, with the course as heading; ",
                               AnchorNote(anchor)));
  return absl::OkStatus();
}

}  // namespace dcloc
