#include "core/update/false_hits.h"

#include <cmath>

#include "core/passes/pass_centers.h"

namespace dcloc {
namespace {

constexpr double kDecoyDistance_m = 1.7;  // beside its landmark: in the same surroundings
constexpr double kTurn_rad = 2.4;         // golden angle: decoys lie to all sides in turn

}  // namespace

void FalseHits::Add(std::span<const LandmarkPosition> positions, std::span<const Landmark> seen,
                    const CenterMatchingOptions& options) {
  const std::vector<LandmarkPosition> centers = PositionsOf(seen);
  const std::vector<CenterMatch> position_of = MatchCenters(centers, positions, options);
  std::vector<LandmarkPosition> free;
  std::vector<std::uint32_t> scans;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (position_of[i].center != kNoCenter) continue;
    free.push_back(centers[i]);
    scans.push_back(seen[i].scan_count);
  }
  std::vector<LandmarkPosition> decoys(positions.begin(), positions.end());
  for (std::size_t i = 0; i < decoys.size(); ++i) {
    const double angle_rad = kTurn_rad * static_cast<double>(i);
    decoys[i].position_m +=
        kDecoyDistance_m * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  }
  for (const auto& [center, ratio] : MatchCenters(decoys, free, options)) {
    decoys_ += 1.0;
    if (center == kNoCenter) continue;
    hit_decoys_ += 1.0;
    hits_ += scans[center];
  }
}

void FalseHits::Finish() {
  share = (hit_decoys_ + 1.0) / (decoys_ + 50.0);
  mean = (hits_ + 3.0) / (hit_decoys_ + 1.0);
}

}  // namespace dcloc
