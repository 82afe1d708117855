#include "core/update/new_streets.h"

#include <cstdint>
#include <optional>
#include <set>

#include "core/map/point_grid.h"

namespace dcloc {
namespace {

/// Keyframes of the map and new ones, by place.
class Keyframes {
 public:
  explicit Keyframes(double spacing_m) : grid_(spacing_m) {}

  void Add(const Pose3& T_local_keyframe) {
    positions_m_.emplace_back(T_local_keyframe.translation_m.head<2>());
    grid_.Insert(positions_m_.back());
  }

  template <typename Visit>
  void ForEachWithin(const Eigen::Vector2d& p_m, double radius_m, const Visit& visit) const {
    grid_.ForEachNear(p_m, Eigen::Vector2d::Constant(radius_m), [&](std::uint32_t k) {
      if ((positions_m_[k] - p_m).norm() <= radius_m) visit(k);
    });
  }

 private:
  PointGrid grid_;
  std::vector<Eigen::Vector2d> positions_m_;
};

Pose3 LocalPose(const PlacedScan& scan, const Eigen::Vector3d& origin_m) {
  Pose3 T_local_vehicle = scan.T_map_vehicle;
  T_local_vehicle.translation_m -= origin_m;
  return T_local_vehicle;
}

}  // namespace

NewStreets FindNewStreets(std::span<const Pose3> T_local_keyframes,
                          std::span<const PlacedPass> passes, const Eigen::Vector3d& origin_m,
                          int min_witnesses, const NewStreetOptions& options) {
  Keyframes keyframes(options.keyframe_spacing_m);
  for (const Pose3& T_local_keyframe : T_local_keyframes) keyframes.Add(T_local_keyframe);
  std::vector<Pose3> found;
  for (const PlacedPass& pass : passes) {
    for (const PlacedScan& scan : pass.scans) {
      if (!IsChosen(scan, ScanChoice::kBeyondMap)) continue;
      const Pose3 T_local_vehicle = LocalPose(scan, origin_m);
      bool is_near = false;
      keyframes.ForEachWithin(T_local_vehicle.translation_m.head<2>(), options.keyframe_spacing_m,
                              [&](std::uint32_t) { is_near = true; });
      if (is_near) continue;
      keyframes.Add(T_local_vehicle);
      found.push_back(T_local_vehicle);
    }
  }
  std::vector<std::set<Witness>> witnesses(found.size());
  for (const PlacedPass& pass : passes) {
    std::optional<Witness> witness;
    for (const PlacedScan& scan : pass.scans) {
      if (!IsChosen(scan, ScanChoice::kBeyondMap)) continue;
      if (!witness) witness = WitnessOf(pass);
      keyframes.ForEachWithin(LocalPose(scan, origin_m).translation_m.head<2>(), options.lane_m,
                              [&](std::uint32_t k) {
                                if (k < T_local_keyframes.size()) return;
                                witnesses[k - T_local_keyframes.size()].insert(*witness);
                              });
    }
  }
  NewStreets streets;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const bool is_proven = static_cast<int>(witnesses[k].size()) >= min_witnesses;
    (is_proven ? streets.joined_m : streets.unproven_m) += options.keyframe_spacing_m;
    if (is_proven) streets.T_local_keyframes.push_back(found[k]);
  }
  return streets;
}

}  // namespace dcloc
