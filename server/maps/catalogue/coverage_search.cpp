#include "server/maps/catalogue/coverage_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/geometry/degrees.h"

namespace dcloc::server {
namespace {

/// Of a degree of latitude; its spread over the ellipsoid is 1 %, by which the search is widened.
constexpr double kDegree_m = 111'320.0;
constexpr double kWiden = 1.01;
/// Near the poles a degree of longitude is next to nothing.
constexpr double kMinCosine = 1e-6;

}  // namespace

void NearestVersions::Add(std::string map_name, std::int64_t version, double distance_m) {
  if (distance_m > radius_m_) return;
  const auto [entry, is_new] = distances_m_.try_emplace({std::move(map_name), version}, distance_m);
  entry->second = std::min(entry->second, distance_m);
}

std::vector<CoverageRecord> NearestVersions::Records() const {
  std::vector<CoverageRecord> records;
  for (const auto& [key, distance_m] : distances_m_) {
    records.push_back({.map_name = key.first, .version = key.second, .distance_m = distance_m});
  }
  return records;
}

Rectangle Around(double x, double y, double reach_x, double reach_y) {
  return {.min_x = x - reach_x, .max_x = x + reach_x, .min_y = y - reach_y, .max_y = y + reach_y};
}

double EarthWindow::DistanceTo_m(const Rectangle& degrees) const {
  return kDegree_m * DistanceTo(degrees, longitude_deg, latitude_deg, longitude_scale);
}

std::array<EarthWindow, 3> EarthWindows(const GeodeticPosition& position, double radius_m) {
  const double cosine = std::max(kMinCosine, std::cos(position.latitude_deg * kRadPerDeg));
  const double latitude_reach_deg = kWiden * radius_m / kDegree_m;
  const double longitude_reach_deg = std::min(180.0, latitude_reach_deg / cosine);
  std::array<EarthWindow, 3> windows;
  for (std::size_t turn = 0; turn < windows.size(); ++turn) {
    const double longitude_deg = position.longitude_deg + 360.0 * (static_cast<double>(turn) - 1.0);
    windows[turn] = {.longitude_deg = longitude_deg,
                     .latitude_deg = position.latitude_deg,
                     .longitude_scale = cosine,
                     .reach = Around(longitude_deg, position.latitude_deg, longitude_reach_deg,
                                     latitude_reach_deg)};
  }
  return windows;
}

void KeepNearest(int limit, std::vector<CoverageRecord>* records) {
  std::ranges::stable_sort(*records, {}, &CoverageRecord::distance_m);
  if (static_cast<int>(records->size()) > limit) records->resize(static_cast<std::size_t>(limit));
}

}  // namespace dcloc::server
