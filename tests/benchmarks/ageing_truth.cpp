#include "tests/benchmarks/ageing_truth.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <set>

#include "core/map/point_grid.h"
#include "core/passes/placed_landmark.h"

namespace dcloc::benchmarks {
namespace {

constexpr double kSame_m = 0.5;
constexpr int kSeenRows = 3;

enum class Kind { kStanding, kWent, kCame, kParked };

/// A scatterer that a pass saw.
struct Seen {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  Kind kind = Kind::kStanding;
  int passes = 0;  ///< that saw it, without the base pass
};

class Truth {
 public:
  Truth(const simulation::AgedWorld& aged, const SimulatedPass& base,
        const std::vector<SimulatedPass>& passes, const std::vector<PlacedPass>& placed) {
    for (const simulation::ScattererChange& change : aged.changes) {
      (change.came ? came_ : went_).insert(change.scatterer.id);
    }
    Add(base, nullptr);
    for (std::size_t i = 0; i < passes.size(); ++i) Add(passes[i], &placed[i]);
    for (const Seen& seen : seen_) grid_.Insert(seen.p_m);
  }

  const std::vector<Seen>& seen() const { return seen_; }

  /// The distance of the nearest of a kind, at most `kSame_m`; infinite where there is none.
  double Nearest(const Eigen::Vector2d& p_m, Kind kind) const {
    double nearest_m = INFINITY;
    grid_.ForEachNear(p_m, Eigen::Vector2d::Constant(kSame_m), [&](std::uint32_t i) {
      if (seen_[i].kind != kind) return;
      const double distance_m = (seen_[i].p_m - p_m).norm();
      if (distance_m <= kSame_m) nearest_m = std::min(nearest_m, distance_m);
    });
    return nearest_m;
  }

 private:
  struct Sum {
    Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
    int rows = 0;
  };

  // The base pass has no `placed`: all its scans count.
  void Add(const SimulatedPass& pass, const PlacedPass* placed) {
    const int counts = placed == nullptr ? 0 : 1;
    std::set<Stamp> good;
    if (placed != nullptr) {
      for (const PlacedScan& scan : placed->scans) {
        if (scan.is_good) good.insert(scan.stamp);
      }
    }
    std::map<std::uint32_t, Sum> sums;
    for (std::size_t i = 0; i < pass.truth.size(); ++i) {
      if (placed != nullptr && !good.contains(pass.drive.scans[i].scan.stamp)) continue;
      for (const simulation::Echo& echo : pass.truth[i].echoes) {
        if (echo.source != simulation::EchoSource::kStatic) continue;
        Sum& sum = sums[echo.id];
        sum.p_m += echo.p_map.head<2>();
        ++sum.rows;
      }
    }
    for (const auto& [id, sum] : sums) {
      if (sum.rows < kSeenRows) continue;
      const Eigen::Vector2d p_m = sum.p_m / sum.rows;
      const Kind kind = KindOf(id, p_m, pass);
      if (kind != Kind::kParked) {
        const auto [at, is_new] = known_.try_emplace(id, seen_.size());
        if (!is_new) {
          seen_[at->second].passes += counts;
          continue;
        }
      }
      seen_.push_back({p_m, kind, counts});
    }
  }

  Kind KindOf(std::uint32_t id, const Eigen::Vector2d& p_m, const SimulatedPass& pass) const {
    for (const simulation::ParkedVehicle& parked : pass.parked) {
      const Eigen::Vector2d p_body = parked.T_map_body.Inverse() * p_m;
      if (std::abs(p_body.x()) < 0.5 * parked.vehicle.length_m + 0.3 &&
          std::abs(p_body.y()) < 0.5 * parked.vehicle.width_m + 0.3) {
        return Kind::kParked;
      }
    }
    if (came_.contains(id)) return Kind::kCame;
    return went_.contains(id) ? Kind::kWent : Kind::kStanding;
  }

  std::set<std::uint32_t> came_, went_;
  std::map<std::uint32_t, std::size_t> known_;
  std::vector<Seen> seen_;
  PointGrid grid_{1.0};
};

bool HasNear(const PointGrid& grid, const Eigen::Vector2d& p_m, double reach_m) {
  bool has_near = false;
  grid.ForEachNear(p_m, Eigen::Vector2d::Constant(reach_m),
                   [&](std::uint32_t) { has_near = true; });
  return has_near;
}

void CountKnown(const MapUpdate& update, const Truth& truth, AgeingCounts& counts) {
  for (const LandmarkHistory& landmark : update.known) {
    const Eigen::Vector2d p_m = landmark.p_map_m.head<2>();
    const double standing_m = truth.Nearest(p_m, Kind::kStanding);
    const double went_m = truth.Nearest(p_m, Kind::kWent);
    const double came_m = truth.Nearest(p_m, Kind::kCame);
    const double parked_m = truth.Nearest(p_m, Kind::kParked);
    const bool is_kept = landmark.fate == LandmarkFate::kKept;
    if (std::isinf(standing_m) && std::isinf(came_m) && std::isinf(went_m)) {
      counts.base_parked += std::isfinite(parked_m) ? 1 : 0;
    }
    if (std::isfinite(went_m) && std::isinf(standing_m) && std::isinf(came_m) &&
        std::isinf(parked_m)) {
      ++counts.went;
      counts.went_gone += is_kept ? 0 : 1;
    }
  }
}

/// The landmarks of `map`, in its frame [m].
std::vector<Eigen::Vector2d> LandmarksInMap(const EditableMap& map) {
  std::vector<Eigen::Vector2d> places_m;
  for (const PlacedLandmark& landmark : LandmarksOf(map)) {
    places_m.push_back(landmark.position.position_m + map.Origin_m().head<2>());
  }
  return places_m;
}

/// Scatterers that two passes saw: what stood, as far as the base map has it, and what came.
void CountScatterers(const MapUpdate& update, const Truth& truth, AgeingCounts& counts) {
  PointGrid base(1.0);
  PointGrid updated(1.0);
  for (const LandmarkHistory& landmark : update.known) base.Insert(landmark.p_map_m.head<2>());
  for (const Eigen::Vector2d& p_m : LandmarksInMap(update.map)) updated.Insert(p_m);
  for (const Seen& seen : truth.seen()) {
    if (seen.passes < 2) continue;
    const bool is_in_update = HasNear(updated, seen.p_m, kSame_m);
    if (seen.kind == Kind::kStanding && HasNear(base, seen.p_m, 0.3)) {
      ++counts.stood;
      counts.stood_lost += is_in_update ? 0 : 1;
    }
    if (seen.kind == Kind::kCame && std::isinf(truth.Nearest(seen.p_m, Kind::kStanding))) {
      ++counts.came;
      counts.came_found += is_in_update ? 1 : 0;
    }
  }
}

}  // namespace

AgeingCounts CountAgeing(const MapUpdate& update, const simulation::AgedWorld& aged,
                         const SimulatedPass& base, const std::vector<SimulatedPass>& passes,
                         const std::vector<PlacedPass>& placed) {
  const Truth truth(aged, base, passes, placed);
  AgeingCounts counts;
  CountKnown(update, truth, counts);
  CountScatterers(update, truth, counts);
  for (const Eigen::Vector2d& p_m : LandmarksInMap(update.map)) {
    const bool is_parked = std::isinf(truth.Nearest(p_m, Kind::kStanding)) &&
                           std::isinf(truth.Nearest(p_m, Kind::kCame)) &&
                           std::isinf(truth.Nearest(p_m, Kind::kWent)) &&
                           std::isfinite(truth.Nearest(p_m, Kind::kParked));
    counts.parked += is_parked ? 1 : 0;
  }
  counts.landmarks = update.map.PointCount();
  return counts;
}

}  // namespace dcloc::benchmarks
