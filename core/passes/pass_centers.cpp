#include "core/passes/pass_centers.h"

#include "core/map/landmark_points.h"

namespace dcloc {

std::vector<Landmark> FusePasses(std::span<const PlacedPass* const> passes,
                                 const Eigen::Vector3d& origin_m, int min_scan_count,
                                 ScanChoice choice) {
  std::vector<MapReturn> returns;
  std::vector<std::uint32_t> pass_of_scan;
  bool has_elevation = true;
  for (std::uint32_t pass = 0; pass < passes.size(); ++pass) {
    has_elevation = has_elevation && passes[pass]->rig.MeasuresElevation();
    for (const PlacedScan& scan : passes[pass]->scans) {
      if (!IsChosen(scan, choice)) continue;
      Pose3 T_local_vehicle = scan.T_map_vehicle;
      T_local_vehicle.translation_m -= origin_m;
      AppendReturns(scan.points, T_local_vehicle, static_cast<std::uint32_t>(pass_of_scan.size()),
                    returns);
      pass_of_scan.push_back(pass);
    }
  }
  FusionOptions options;
  options.min_scan_count = min_scan_count;
  return FuseLandmarks(returns, pass_of_scan, has_elevation, options);
}

LandmarkPosition PositionOf(const Landmark& landmark) {
  return {.position_m = landmark.position_m.head<2>(),
          .covariance_m2 = landmark.covariance_m2.topLeftCorner<2, 2>()};
}

std::vector<LandmarkPosition> PositionsOf(std::span<const Landmark> landmarks) {
  std::vector<LandmarkPosition> positions;
  positions.reserve(landmarks.size());
  for (const Landmark& landmark : landmarks) positions.push_back(PositionOf(landmark));
  return positions;
}

}  // namespace dcloc
