#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/geodetic_anchor.h"
#include "server/maps/catalogue/catalogue.h"

/// What searches for coverage do alike, whatever finds the boxes.
namespace dcloc::server {

/// Keeps each version's least distance within a radius.
class NearestVersions {
 public:
  explicit NearestVersions(double radius_m) : radius_m_(radius_m) {}

  void Add(std::string map_name, std::int64_t version, double distance_m);

  /// By name.
  std::vector<CoverageRecord> Records() const;

 private:
  const double radius_m_;
  std::map<std::pair<std::string, std::int64_t>, double> distances_m_;
};

/// What lies within a reach around a place, in the unit of each axis.
Rectangle Around(double x, double y, double reach_x, double reach_y);

/// A place on the Earth as boxes in degrees see it. There are three of them, a turn apart: boxes
/// across the date line go on above 180, and a place beside it is near both ends.
struct EarthWindow {
  double longitude_deg = 0.0;
  double latitude_deg = 0.0;
  double longitude_scale = 1.0;  ///< what a degree of longitude counts in degrees of latitude
  Rectangle reach;               ///< every box within the radius meets it

  /// On a sphere, which is 1 % off at most.
  double DistanceTo_m(const Rectangle& degrees) const;
};
std::array<EarthWindow, 3> EarthWindows(const GeodeticPosition& position, double radius_m);

/// The nearest ones first, at most `limit`; equally near ones keep their order.
void KeepNearest(int limit, std::vector<CoverageRecord>* records);

}  // namespace dcloc::server
