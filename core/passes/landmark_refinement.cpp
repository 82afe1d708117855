#include "core/passes/landmark_refinement.h"

#include <algorithm>
#include <cstdint>

#include "core/passes/pass_centers.h"

namespace dcloc {
Landmark Blend(const PlacedLandmark& base, const Landmark& fused) {
  const double base_passes = std::max<std::uint16_t>(1, base.point.pass_count);
  const double share = base_passes / (base_passes + fused.pass_count);
  const Eigen::Vector2d apart_m = base.position.position_m - fused.position_m.head<2>();
  Landmark blend = fused;
  blend.position_m.head<2>() += share * apart_m;
  blend.covariance_m2.topLeftCorner<2, 2>() =
      share * base.position.covariance_m2 +
      (1.0 - share) * fused.covariance_m2.topLeftCorner<2, 2>() +
      share * (1.0 - share) * apart_m * apart_m.transpose();
  blend.scan_count += base.point.scan_count;
  blend.pass_count += static_cast<std::uint32_t>(base_passes);
  return blend;
}

std::vector<LandmarkPosition> BlendedPositions(std::span<const PlacedLandmark> base,
                                               std::span<const Landmark> fused,
                                               const CenterMatchingOptions& options) {
  const std::vector<LandmarkPosition> base_positions = PositionsOf(base);
  const std::vector<LandmarkPosition> centers = PositionsOf(fused);
  const std::vector<CenterMatch> center_of = MatchCenters(base_positions, centers, options);
  const std::vector<CenterMatch> base_of = MatchCenters(centers, base_positions, options);
  std::vector<LandmarkPosition> positions;
  for (std::size_t i = 0; i < base_positions.size(); ++i) {
    if (center_of[i].center == kNoCenter) positions.push_back(base_positions[i]);
  }
  for (std::size_t i = 0; i < fused.size(); ++i) {
    positions.push_back(base_of[i].center == kNoCenter
                            ? centers[i]
                            : PositionOf(Blend(base[base_of[i].center], fused[i])));
  }
  return positions;
}

}  // namespace dcloc
