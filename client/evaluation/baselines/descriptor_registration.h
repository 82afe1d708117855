#pragma once

#include "client/evaluation/baselines/planar_registration.h"
#include "core/registration/gicp.h"

namespace dcloc {

/// The paper's data association (III-D.2): radial statistics descriptors of the sub-map and of the
/// landmarks around it, mutual nearest neighbours, RANSAC on rigid motions; then, where asked for,
/// uncertainty-aware GICP (eq 12) from there.
class DescriptorRegistration final : public PlanarRegistration {
 public:
  /// Without `gicp` the answer is RANSAC's, which knows no covariance.
  explicit DescriptorRegistration(std::optional<GicpOptions> gicp) : gicp_(gicp) {}

  std::optional<PlanarFit> Register(std::span<const GaussianPoint<2>> points,
                                    const LocalMap<2>& map, const Pose2& guess,
                                    std::uint64_t seed) const override;

 private:
  std::optional<GicpOptions> gicp_;
};

}  // namespace dcloc
