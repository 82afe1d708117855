#include "client/evaluation/baselines/planar_registration.h"

namespace dcloc {

std::vector<GaussianPoint<2>> InPlane(std::span<const RadarPoint> points) {
  std::vector<GaussianPoint<2>> planar;
  planar.reserve(points.size());
  for (const RadarPoint& point : points) {
    planar.push_back({.mean_m = point.position_m.head<2>(),
                      .covariance_m2 = point.covariance_m2.topLeftCorner<2, 2>()});
  }
  return planar;
}

}  // namespace dcloc
