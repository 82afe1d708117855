#include "core/versions/version_comparison.h"

#include <utility>

namespace dcloc {
namespace {

PlaceSet PlacesOf(const std::vector<PlacedLandmark>& landmarks) {
  std::vector<Eigen::Vector2d> places_m;
  places_m.reserve(landmarks.size());
  for (const PlacedLandmark& landmark : landmarks) {
    places_m.push_back(landmark.position.position_m);
  }
  return PlaceSet(std::move(places_m));
}

}  // namespace

PlaceSet::PlaceSet(std::vector<Eigen::Vector2d> places_m) : places_m_(std::move(places_m)) {
  for (const Eigen::Vector2d& place_m : places_m_) grid_.Insert(place_m);
}

bool PlaceSet::HasNear(const Eigen::Vector2d& p_m, double reach_m) const {
  bool has_near = false;
  grid_.ForEachNear(p_m, Eigen::Vector2d::Constant(reach_m), [&](std::uint32_t i) {
    has_near = has_near || (places_m_[i] - p_m).norm() <= reach_m;
  });
  return has_near;
}

VersionComparison CompareVersions(const EditableMap& old_version, const EditableMap& new_version,
                                  double same_m, const PlaceSet& intermittent) {
  const std::vector<PlacedLandmark> before = LandmarksOf(old_version);
  const std::vector<PlacedLandmark> after = LandmarksOf(new_version);
  const PlaceSet before_places = PlacesOf(before);
  const PlaceSet after_places = PlacesOf(after);
  VersionComparison comparison;
  for (const PlacedLandmark& landmark : before) {
    const Eigen::Vector2d& p_m = landmark.position.position_m;
    if (after_places.HasNear(p_m, same_m)) {
      comparison.common.push_back(landmark);
    } else {
      const bool comes_and_goes = intermittent.HasNear(p_m, same_m);
      (comes_and_goes ? comparison.intermittent : comparison.removed).push_back(landmark);
    }
  }
  for (const PlacedLandmark& landmark : after) {
    if (before_places.HasNear(landmark.position.position_m, same_m)) continue;
    comparison.added.push_back(landmark);
  }
  return comparison;
}

}  // namespace dcloc
