#include "core/submap/submap.h"

#include <algorithm>
#include <utility>

#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

// `point`, seen `motion` before the newest scan, in that scan's vehicle frame.
RadarPoint MovePoint(const RadarPoint& point, const Pose3& T_newest_then, const Eigen::Matrix3d& R,
                     const Matrix6d& drift, bool carry_drift) {
  RadarPoint moved{.position_m = T_newest_then * point.position_m,
                   .covariance_m2 = R * point.covariance_m2 * R.transpose(),
                   .rcs_dbsm = point.rcs_dbsm};
  if (carry_drift) {
    // p = T Exp(xi) p_then: G = R [I, -[p_then]x].
    Eigen::Matrix<double, 3, 6> G;
    G.leftCols<3>() = R;
    G.rightCols<3>() = -R * Skew(point.position_m);
    moved.covariance_m2 += G * drift * G.transpose();
  }
  return moved;
}

}  // namespace

void SubmapWindow::Push(Stamp stamp, int radar_index, std::vector<RadarPoint> points,
                        const Motion& motion) {
  entries_.push_back({stamp, radar_index, std::move(points), motion});
  const auto of_same_radar = [&](const Entry& entry) { return entry.radar_index == radar_index; };
  if (std::count_if(entries_.begin(), entries_.end(), of_same_radar) <= scans_per_radar_) return;
  const auto oldest = std::find_if(entries_.begin(), entries_.end(), of_same_radar);
  const auto next = std::next(oldest);
  // The way over the removed scan becomes part of its successor's.
  next->motion = Compose(oldest->motion, next->motion);
  entries_.erase(oldest);
}

Submap SubmapWindow::Join(bool carry_drift) const {
  Submap submap;
  submap.scan_count = static_cast<int>(entries_.size());
  if (entries_.empty()) return submap;
  submap.span = entries_.back().stamp - entries_.front().stamp;
  std::size_t point_count = 0;
  for (const Entry& entry : entries_) point_count += entry.points.size();
  submap.points.reserve(point_count);

  Motion since_then;  // from the entry at hand to the newest
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    const Pose3 T_newest_then = since_then.T_from_to.Inverse();
    const Eigen::Matrix3d R = T_newest_then.Rotation();
    const Matrix6d drift = InvertCovariance<3>(since_then.T_from_to, since_then.covariance);
    for (const RadarPoint& point : entry->points) {
      submap.points.push_back(MovePoint(point, T_newest_then, R, drift, carry_drift));
    }
    since_then = Compose(entry->motion, since_then);
  }
  return submap;
}

}  // namespace dcloc
