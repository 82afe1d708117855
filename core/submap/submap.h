#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/radar/static_points.h"
#include "core/submap/odometry.h"

namespace dcloc {

/// The static points of the last scans, all in the vehicle frame at the newest one (METHOD eq 7-8).
struct Submap {
  std::vector<RadarPoint> points;
  int scan_count = 0;
  std::chrono::nanoseconds span{0};  ///< from the oldest scan to the newest
};

/// Keeps the last `scans_per_radar` scans of each radar of a rig and joins them on demand.
class SubmapWindow {
 public:
  explicit SubmapWindow(int scans_per_radar) : scans_per_radar_(scans_per_radar) {}

  /// Adds the points (vehicle frame at `stamp`) of a scan by radar `radar_index`; `motion` leads
  /// from the scan before, of whatever radar, to this one. Stamps do not go back.
  void Push(Stamp stamp, int radar_index, const std::vector<RadarPoint>& points,
            const Motion& motion);

  /// All kept points in the vehicle frame at the newest scan. With `carry_drift` each point's
  /// covariance holds what the motion since its scan adds: G S G^T (METHOD 3).
  Submap Join(bool carry_drift) const;

  /// The same for matching, in the plane (Dim = 2) or in space, in place of what `points` held; its
  /// memory is used again. Of more than `max_count` >= 1 points every n-th.
  template <int Dim>
  void Join(bool carry_drift, std::size_t max_count, std::vector<GaussianPoint<Dim>>& points) const;

  int scan_count() const { return static_cast<int>(entries_.size()); }
  std::size_t point_count() const;
  std::chrono::nanoseconds span() const;  ///< from the oldest scan to the newest

  void Clear() { entries_.clear(); }

 private:
  // A point in single precision: it rounds by some micrometres, and each vehicle holds thousands.
  struct KeptPoint {
    explicit KeptPoint(const RadarPoint& point);
    RadarPoint Unpack() const;

    Eigen::Vector3f position_m;
    std::array<float, 6> covariance_m2;  // xx, xy, xz, yy, yz, zz
    float rcs_dbsm;
  };
  struct Entry {
    Stamp stamp;
    int radar_index;
    std::vector<KeptPoint> points;
    Motion motion;  // from the entry before to this one
  };

  // Calls visit(point, carried) for every kept point, newest scan first; `carried` leads from the
  // point's scan to the newest one.
  template <typename Visit>
  void ForEachPoint(const Visit& visit) const;

  int scans_per_radar_;
  std::vector<Entry> entries_;  // oldest first
};

}  // namespace dcloc
