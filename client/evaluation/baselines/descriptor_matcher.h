#pragma once

#include "client/evaluation/baselines/matcher.h"
#include "core/registration/gicp.h"

namespace dcloc {

/// The paper's data association (III-D.2): radial statistics descriptors of the sub-map and of the
/// landmarks around it, mutual nearest neighbours, RANSAC on rigid motions; then, where asked for,
/// uncertainty-aware GICP (eq 12) from there.
class DescriptorMatcher final : public Matcher {
 public:
  /// Without `gicp` the answer is RANSAC's, which knows no covariance.
  explicit DescriptorMatcher(std::optional<GicpOptions> gicp) : gicp_(gicp) {}

  std::optional<Match> Find(std::span<const RadarPoint> live, const LocalMap<2>& map,
                            const Pose2& predicted, std::uint64_t seed) const override;

 private:
  std::optional<GicpOptions> gicp_;
};

/// The points in the plane, as GICP takes them.
std::vector<GaussianPoint<2>> InPlane(std::span<const RadarPoint> points);

}  // namespace dcloc
