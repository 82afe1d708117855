#include "core/update/exposure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/geometry/degrees.h"
#include "core/map/point_grid.h"

namespace dcloc {
namespace {

constexpr double kMaxRange_m = 100.0;
constexpr std::array<double, kRangeBinCount> kRangeEnds_m = {6,  12, 18, 25,         33,
                                                             43, 55, 75, kMaxRange_m};
constexpr double kBearingBin_rad = 15.0 * kRadPerDeg;
// A target this much nearer at the same bearing may hide what is behind it.
constexpr double kHiding_m = 3.0;
constexpr double kSector_rad = 2.0 * kRadPerDeg;

/// The nearest target of a scan by bearing.
class Nearest {
 public:
  Nearest(std::span<const RadarPoint> points, const Pose3& T_vehicle_radar) {
    nearest_m_.fill(std::numeric_limits<double>::infinity());
    const Pose3 T_radar_vehicle = T_vehicle_radar.Inverse();
    for (const RadarPoint& point : points) {
      const Eigen::Vector3d p_radar = T_radar_vehicle * point.position_m;
      double& nearest_m = nearest_m_[SectorOf(std::atan2(p_radar.y(), p_radar.x()))];
      nearest_m = std::min(nearest_m, p_radar.head<2>().norm());
    }
  }

  bool IsHidden(double range_m, double bearing_rad) const {
    return nearest_m_[SectorOf(bearing_rad)] < range_m - kHiding_m;
  }

 private:
  static constexpr std::size_t kSectorCount = 181;
  static std::size_t SectorOf(double bearing_rad) {
    const double sector = (bearing_rad + std::numbers::pi) / kSector_rad;
    return std::min(kSectorCount - 1, static_cast<std::size_t>(std::max(0.0, sector)));
  }
  std::array<double, kSectorCount> nearest_m_;
};

class Exposer {
 public:
  explicit Exposer(std::span<const Eigen::Vector2d> places_m)
      : places_m_(places_m), exposures_(places_m.size()) {
    for (const Eigen::Vector2d& place_m : places_m) grid_.Insert(place_m);
    for (Exposure& exposure : exposures_) exposure.fill(0);
  }

  void Look(const Pose2& T_local_radar, const Nearest& nearest) {
    const Pose2 T_radar_local = T_local_radar.Inverse();
    grid_.ForEachNear(
        T_local_radar.translation_m, Eigen::Vector2d::Constant(kMaxRange_m), [&](std::uint32_t i) {
          const Eigen::Vector2d p_radar = T_radar_local * places_m_[i];
          const double range_m = p_radar.norm();
          if (range_m >= kMaxRange_m) return;
          const double bearing_rad = std::atan2(p_radar.y(), p_radar.x());
          const auto bearing = static_cast<std::size_t>(std::abs(bearing_rad) / kBearingBin_rad);
          if (bearing >= kBearingBinCount) return;
          const bool is_hidden = nearest.IsHidden(range_m, bearing_rad);
          ++exposures_[i][View(range_m, bearing, is_hidden)];
        });
  }

  std::vector<Exposure> Take() && { return std::move(exposures_); }

 private:
  static std::size_t View(double range_m, std::size_t bearing, bool is_hidden) {
    const auto range = static_cast<std::size_t>(std::ranges::upper_bound(kRangeEnds_m, range_m) -
                                                kRangeEnds_m.begin());
    return (range * kBearingBinCount + bearing) * 2 + (is_hidden ? 1 : 0);
  }

  std::span<const Eigen::Vector2d> places_m_;
  PointGrid grid_{4.0};
  std::vector<Exposure> exposures_;
};

}  // namespace

std::vector<Exposure> Expose(const PlacedPass& pass, const Eigen::Vector3d& origin_m,
                             std::span<const Eigen::Vector2d> places_m, ScanChoice choice) {
  Exposer exposer(places_m);
  for (const PlacedScan& scan : pass.scans) {
    if (!IsChosen(scan, choice)) continue;
    const Pose3& T_vehicle_radar = pass.rig.radars[scan.radar].T_vehicle_radar;
    Pose3 T_local_radar = scan.T_map_vehicle * T_vehicle_radar;
    T_local_radar.translation_m -= origin_m;
    exposer.Look(Flatten(T_local_radar), Nearest(scan.points, T_vehicle_radar));
  }
  return std::move(exposer).Take();
}

std::vector<Exposure> ExposeFrom(std::span<const Pose3> T_local_vehicles, const Rig& rig,
                                 std::span<const Eigen::Vector2d> places_m) {
  Exposer exposer(places_m);
  const Nearest nothing({}, Pose3{});
  for (const Pose3& T_local_vehicle : T_local_vehicles) {
    for (const RadarModel& radar : rig.radars) {
      exposer.Look(Flatten(T_local_vehicle * radar.T_vehicle_radar), nothing);
    }
  }
  return std::move(exposer).Take();
}

}  // namespace dcloc
