#include "core/mapping/fix_alignment.h"

#include <algorithm>
#include <cmath>

namespace dcloc {
namespace {

constexpr std::size_t kMaxTried = 40;     // fixes that candidates are made of
constexpr double kAgreementSigmas = 3.0;  // 99 % of what is normal in the plane

// A fix and where the nodes say that the vehicle was.
struct Tie {
  Eigen::Vector2d p_nodes;
  Eigen::Vector2d p_map;
  double sigma_m;
};

Pose2 FromTwo(const Tie& a, const Tie& b) {
  const Eigen::Vector2d d_nodes = b.p_nodes - a.p_nodes;
  const Eigen::Vector2d d_map = b.p_map - a.p_map;
  Pose2 T{.yaw_rad =
              std::atan2(d_nodes.x() * d_map.y() - d_nodes.y() * d_map.x(), d_nodes.dot(d_map))};
  T.translation_m = 0.5 * (a.p_map + b.p_map) - T.Rotation() * (0.5 * (a.p_nodes + b.p_nodes));
  return T;
}

// How many agree, and how far apart they lie.
struct Agreement {
  std::size_t count = 0;
  double spread_m = 0.0;
};
Agreement AgreeingWith(const Pose2& T, std::span<const Tie> ties, double slack_m) {
  Agreement agreement;
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d max_m = -min_m;
  for (const Tie& tie : ties) {
    if ((T * tie.p_nodes - tie.p_map).norm() > kAgreementSigmas * tie.sigma_m + slack_m) continue;
    ++agreement.count;
    min_m = min_m.cwiseMin(tie.p_map);
    max_m = max_m.cwiseMax(tie.p_map);
  }
  if (agreement.count > 0) agreement.spread_m = (max_m - min_m).norm();
  return agreement;
}

}  // namespace

std::optional<Pose2> AlignWithFixes(std::span<const Pose2> T_nodes, std::span<const NodeFix> fixes,
                                    double slack_m) {
  std::vector<Tie> ties;
  ties.reserve(fixes.size());
  for (const NodeFix& fix : fixes) {
    ties.push_back({T_nodes[fix.node] * fix.p_node, fix.p_map, fix.sigma_m});
  }
  const std::size_t stride = std::max<std::size_t>(1, ties.size() / kMaxTried);
  std::optional<Pose2> best;
  std::size_t best_count = kMinAgreeingFixes - 1;
  for (std::size_t a = 0; a < ties.size(); a += stride) {
    for (std::size_t b = a + stride; b < ties.size(); b += stride) {
      if ((ties[a].p_nodes - ties[b].p_nodes).norm() < kMinFixSpread_m) continue;
      const Pose2 T = FromTwo(ties[a], ties[b]);
      const Agreement agreement = AgreeingWith(T, ties, slack_m);
      if (agreement.count <= best_count || agreement.spread_m < kMinFixSpread_m) continue;
      best_count = agreement.count;
      best = T;
    }
  }
  return best;
}

}  // namespace dcloc
