#include "core/update/seen_places.h"

#include <utility>

#include "core/passes/pass_centers.h"
#include "core/update/exposure.h"

namespace dcloc {
namespace {

constexpr int kMinOtherScans = 3;  // of all passes together, that saw something else

class PlaceFinder {
 public:
  PlaceFinder(const BaseLandmarks& base, const UpdatedKeyframes& keyframes,
              std::span<const PlacedPass* const> passes, const Eigen::Vector3d& origin_m,
              const SeenPlacesOptions& options)
      : base_(base),
        keyframes_(keyframes),
        passes_(passes),
        origin_m_(origin_m),
        options_(options) {}

  SeenPlaces Run() && {
    FindOthers();
    for (const PlacedPass* const pass : passes_) LookAtPlaces(pass);
    places_.false_hits.Finish();
    return std::move(places_);
  }

 private:
  enum class Kind { kInBase, kInJoinedStreet, kKnown };

  // What the passes together see: where the base map has nothing, in its streets and then in new
  // ones, and after it where it has. Scans beyond the map are placed well enough among themselves,
  // but not beside what the map has: they speak of new streets alone.
  void FindOthers() {
    places_.positions = base_.positions;
    places_.known_count = base_.positions.size();
    const std::vector<Landmark> tracked = Fused(ScanChoice::kTracked);
    Take(tracked, Kind::kInBase);
    places_.found_in_base_count = places_.others.size();
    if (keyframes_.AnyJoined()) Take(Fused(ScanChoice::kAll), Kind::kInJoinedStreet);
    places_.found_count = places_.others.size();
    Take(tracked, Kind::kKnown);
  }

  std::vector<Landmark> Fused(ScanChoice choice) const {
    return FusePasses(passes_, origin_m_, kMinOtherScans, choice);
  }

  // Those of one kind become the next places.
  void Take(const std::vector<Landmark>& seen, Kind wanted) {
    const std::vector<LandmarkPosition> positions = PositionsOf(seen);
    const std::vector<CenterMatch> known =
        MatchCenters(positions, base_.positions, options_.matching);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Kind kind = known[i].center != kNoCenter           ? Kind::kKnown
                        : keyframes_.IsInJoinedStreet(seen[i]) ? Kind::kInJoinedStreet
                                                               : Kind::kInBase;
      if (kind != wanted) continue;
      places_.others.push_back(seen[i]);
      places_.known_of_other.push_back(known[i].center);
      places_.positions.push_back(positions[i]);
    }
  }

  // What one pass sees of places.
  struct Look {
    std::vector<Landmark> seen;
    std::vector<CenterMatch> matches;
    std::vector<Exposure> exposures;
  };
  Look LookOf(const PlacedPass* pass, std::span<const LandmarkPosition> places,
              ScanChoice choice) const {
    Look look{.seen = FusePasses({&pass, 1}, origin_m_, options_.min_center_scans, choice)};
    look.matches = MatchCenters(places, PositionsOf(look.seen), options_.matching);
    std::vector<Eigen::Vector2d> places_m;
    for (const LandmarkPosition& place : places) places_m.push_back(place.position_m);
    look.exposures = Expose(*pass, origin_m_, places_m, choice);
    return look;
  }

  void LookAtPlaces(const PlacedPass* pass) {
    const std::span<const LandmarkPosition> all(places_.positions);
    const std::size_t joined_begin = places_.known_count + places_.found_in_base_count;
    const auto joined =
        all.subspan(joined_begin, places_.found_count - places_.found_in_base_count);
    const Look in_base = LookOf(pass, all, ScanChoice::kTracked);
    const Look in_joined = joined.empty() ? Look{} : LookOf(pass, joined, ScanChoice::kAll);
    PassSightings& sightings = places_.sightings.emplace_back();
    std::vector<double>& ratios = places_.position_ratios.emplace_back();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool is_in_joined = i >= joined_begin && i - joined_begin < joined.size();
      const Look& look = is_in_joined ? in_joined : in_base;
      const std::size_t k = is_in_joined ? i - joined_begin : i;
      const CenterMatch& match = look.matches[k];
      sightings.exposures.push_back(look.exposures[k]);
      ratios.push_back(match.position_ratio);
      sightings.hits.push_back(
          match.center == kNoCenter ? 0 : static_cast<int>(look.seen[match.center].scan_count));
    }
    places_.false_hits.Add(all.first(places_.known_count + places_.found_count), in_base.seen,
                           options_.matching);
  }

  const BaseLandmarks& base_;
  const UpdatedKeyframes& keyframes_;
  std::span<const PlacedPass* const> passes_;
  Eigen::Vector3d origin_m_;
  const SeenPlacesOptions& options_;
  SeenPlaces places_;
};

}  // namespace

std::vector<Eigen::Vector2d> SeenPlaces::FirstPlaces_m(std::size_t count) const {
  std::vector<Eigen::Vector2d> places_m;
  for (std::size_t i = 0; i < count; ++i) places_m.push_back(positions[i].position_m);
  return places_m;
}

SeenPlaces FindSeenPlaces(const BaseLandmarks& base, const UpdatedKeyframes& keyframes,
                          std::span<const PlacedPass* const> passes,
                          const Eigen::Vector3d& origin_m, const SeenPlacesOptions& options) {
  return PlaceFinder(base, keyframes, passes, origin_m, options).Run();
}

}  // namespace dcloc
