#include "core/geometry/rigid_fit.h"

#include <cmath>

namespace dcloc {

Pose2 FitRigid(std::span<const PlacePair> pairs) {
  if (pairs.empty()) return {};
  Eigen::Vector2d mean_a_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_b_m = Eigen::Vector2d::Zero();
  for (const PlacePair& pair : pairs) {
    mean_a_m += pair.p_a_m;
    mean_b_m += pair.p_b_m;
  }
  mean_a_m /= static_cast<double>(pairs.size());
  mean_b_m /= static_cast<double>(pairs.size());
  double dot = 0.0;
  double cross = 0.0;
  for (const PlacePair& pair : pairs) {
    const Eigen::Vector2d a_m = pair.p_a_m - mean_a_m;
    const Eigen::Vector2d b_m = pair.p_b_m - mean_b_m;
    dot += b_m.dot(a_m);
    cross += b_m.x() * a_m.y() - b_m.y() * a_m.x();
  }
  Pose2 T_a_b{.yaw_rad = pairs.size() > 1 ? std::atan2(cross, dot) : 0.0};
  T_a_b.translation_m = mean_a_m - T_a_b.Rotation() * mean_b_m;
  return T_a_b;
}

}  // namespace dcloc
