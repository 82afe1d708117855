#include "server/maps/catalogue/coverage.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace dcloc::server {
namespace {

constexpr double kSquare_m = 25.0;

void Extend(double x, double y, Rectangle* rectangle) {
  rectangle->min_x = std::min(rectangle->min_x, x);
  rectangle->max_x = std::max(rectangle->max_x, x);
  rectangle->min_y = std::min(rectangle->min_y, y);
  rectangle->max_y = std::max(rectangle->max_y, y);
}

/// Around the corners: over 25 m the Earth's curvature is micrometres.
Rectangle DegreesOf(const GeodeticAnchor& anchor, const Rectangle& map_m, double z_m) {
  std::optional<Rectangle> degrees;
  for (const double x : {map_m.min_x, map_m.max_x}) {
    for (const double y : {map_m.min_y, map_m.max_y}) {
      const GeodeticPosition corner = GeodeticFromMap(anchor, {x, y, z_m});
      double longitude_deg = corner.longitude_deg;
      // The first corner may lie on the other side of the date line.
      if (degrees && longitude_deg < degrees->min_x - 180.0) longitude_deg += 360.0;
      if (degrees && longitude_deg > degrees->max_x + 180.0) {
        degrees->min_x += 360.0;
        degrees->max_x += 360.0;
      }
      if (!degrees) {
        degrees = Rectangle{longitude_deg, longitude_deg, corner.latitude_deg, corner.latitude_deg};
      }
      Extend(longitude_deg, corner.latitude_deg, &*degrees);
    }
  }
  return *degrees;
}

}  // namespace

std::vector<CoverageBox> CoverageOf(const RadarMap& map) {
  std::map<std::pair<std::int64_t, std::int64_t>, Rectangle> squares;
  const auto keyframe_count = map.info().keyframe_count;
  for (std::size_t i = 0; i < keyframe_count; ++i) {
    const Eigen::Vector3d p_map = map.keyframe(i).T_map_keyframe.translation_m;
    const auto [square, is_new] =
        squares.try_emplace({static_cast<std::int64_t>(std::floor(p_map.x() / kSquare_m)),
                             static_cast<std::int64_t>(std::floor(p_map.y() / kSquare_m))},
                            Rectangle{p_map.x(), p_map.x(), p_map.y(), p_map.y()});
    Extend(p_map.x(), p_map.y(), &square->second);
    if (i + 1 == keyframe_count) continue;
    // The street goes on to the next one; where that is far, the drive was interrupted.
    const Eigen::Vector3d p_next = map.keyframe(i + 1).T_map_keyframe.translation_m;
    const bool goes_on = (p_next - p_map).head<2>().norm() <= kSquare_m;
    if (goes_on) Extend(p_next.x(), p_next.y(), &square->second);
  }
  const double z_m = 0.5 * (map.info().min_map_m.z() + map.info().max_map_m.z());
  std::vector<CoverageBox> boxes;
  for (const auto& [key, rectangle] : squares) {
    CoverageBox box{.map_m = rectangle, .degrees = std::nullopt};
    if (map.info().anchor) box.degrees = DegreesOf(*map.info().anchor, rectangle, z_m);
    boxes.push_back(box);
  }
  return boxes;
}

double DistanceTo(const Rectangle& rectangle, double x, double y, double x_scale) {
  const double dx = x_scale * std::max({rectangle.min_x - x, x - rectangle.max_x, 0.0});
  const double dy = std::max({rectangle.min_y - y, y - rectangle.max_y, 0.0});
  return std::hypot(dx, dy);
}

}  // namespace dcloc::server
