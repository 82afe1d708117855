#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/gaussian_point.h"
#include "core/odometry/motion.h"
#include "core/options/option_fields.h"
#include "core/radar/static_points.h"

namespace dcloc {

/// A sub-map: the static points of the last scans, all in the vehicle frame at the newest one
/// (METHOD eq 7-8).
struct Submap {
  std::vector<RadarPoint> points;
  int scan_count = 0;
  std::chrono::nanoseconds span{0};  ///< from the oldest scan to the newest
};

/// The same for matching, in the plane (Dim = 2) or in space.
template <int Dim>
struct LiveSubmap {
  /// The points of one scan: [begin, end).
  struct Part {
    int radar_index = 0;  ///< in the rig
    Pose3 T_newest_then;  ///< the vehicle at the scan, in its frame at the newest one
    std::size_t begin = 0;
    std::size_t end = 0;
  };
  std::vector<GaussianPoint<Dim>> points;
  std::vector<Part> parts;  ///< in the order of the points, newest scan first
};

/// What a sub-map does not hold.
struct SubmapOptions {
  /// A scan that is older than this beside the newest is dropped: its radar has fallen silent.
  std::chrono::nanoseconds max_age = std::chrono::milliseconds(2500);
  int max_scan_points = 1500;  ///< a fuller scan is thinned evenly
};
std::span<const OptionField<SubmapOptions>> FieldsOf(const SubmapOptions& options);
absl::Status Validate(const SubmapOptions& options);

/// Whether what the vehicle's motion since a point's scan adds to its covariance is added.
enum class DriftCovariance { kLeftOut, kAdded };

/// Keeps the last `scans_per_radar` scans of each radar of a rig and joins them on demand.
class SubmapWindow {
 public:
  explicit SubmapWindow(int scans_per_radar, const SubmapOptions& options = {})
      : scans_per_radar_(scans_per_radar), options_(options) {}

  /// Adds the points (vehicle frame at `stamp`) of a scan by radar `radar_index`; `motion` leads
  /// from the scan before, of whatever radar, to this one. Stamps do not go back.
  void Push(Stamp stamp, int radar_index, const std::vector<RadarPoint>& points,
            const Motion& motion);

  /// Adds the points (vehicle frame at `stamp`) of a scan that comes late. One from before the
  /// oldest scan, or all that are kept of its radar, is dropped. Returns whether it is kept.
  bool Insert(Stamp stamp, int radar_index, const std::vector<RadarPoint>& points);

  /// All kept points in the vehicle frame at the newest scan. Where `drift` is added, G S G^T is
  /// added to each point's covariance for the motion since its scan (METHOD 3).
  Submap Join(DriftCovariance drift) const;

  /// The same for registration, into `submap`, whose former contents are replaced; its memory is
  /// reused. If there are more than `max_count` >= 1 points, every n-th is taken.
  template <int Dim>
  void Join(DriftCovariance drift, std::size_t max_count, LiveSubmap<Dim>& submap) const;

  /// Drops the points of all scans of a radar: they lie elsewhere than was thought.
  void DropPoints(int radar_index);

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
    Eigen::Vector2f slant_per_m;
  };
  struct Entry {
    Stamp stamp{};
    int radar_index = 0;
    std::vector<KeptPoint> points;
    Motion motion;  // from the entry before to this one
  };

  // Calls visit(entry, T_newest_then, carried) for every kept scan, newest first; both lead from it
  // to the newest one.
  template <typename Visit>
  void ForEachScan(const Visit& visit) const;

  void Fill(Entry& entry, const std::vector<RadarPoint>& points) const;
  std::vector<Entry>::iterator MakeRoom(int radar_index);

  int scans_per_radar_;
  SubmapOptions options_;
  std::vector<Entry> entries_;  // oldest first
};

}  // namespace dcloc
