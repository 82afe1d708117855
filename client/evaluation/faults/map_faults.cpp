#include "client/evaluation/faults/map_faults.h"

#include <algorithm>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/map/editable_map.h"

namespace dcloc::faults {
namespace {

Fault MakeMapFault(const char* id, std::string label, double begin_s,
                   std::optional<double> duration_s, double share) {
  return {.id = absl::StrCat("map-", id),
          .family = "map",
          .label = std::move(label),
          .begin_s = begin_s,
          .duration_s = duration_s,
          .apply = [share](Stream& stream, const Window& window, std::uint64_t seed) {
            ReplaceLandmarks(stream, window, share, seed);
          }};
}

Fault MakeGap(const char* id, std::string label, double duration_s) {
  return {.id = absl::StrCat("map-", id),
          .family = "map",
          .label = std::move(label),
          .duration_s = duration_s,
          .apply = [](Stream& stream, const Window& window, std::uint64_t) {
            RemoveStreet(stream, window);
          }};
}

// A street without any landmark is no fault of a map.
void Replace(const EditableMap& map, Stream& stream) {
  auto bytes = ToMapBytes(map);
  if (!bytes.ok()) return;
  if (auto changed = RadarMap::FromBytes(*std::move(bytes)); changed.ok()) stream.map = *changed;
}

// Whether the vehicle is nearest to the place within the window.
bool IsDrivenWithin(const Window& window, const Stream& stream, const Eigen::Vector3d& p_map) {
  const auto nearest = std::ranges::min_element(stream.scans, {}, [&](const StreamScan& entry) {
    return (entry.T_map_vehicle.translation_m - p_map).head<2>().squaredNorm();
  });
  return window.Contains(nearest->measured);
}

MapPoint Mirrored(MapPoint point) {
  point.y_m = -point.y_m;
  point.xy_m2 = -point.xy_m2;
  point.yz_m2 = -point.yz_m2;
  return point;
}

}  // namespace

void ReplaceLandmarks(Stream& stream, const Window& window, double share, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::bernoulli_distribution is_replaced(share);
  EditableMap map = ToEditable(*stream.map);
  const std::vector<EditableKeyframe> original = map.keyframes;
  const std::size_t count = original.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p_map = stream.map->keyframe(i).T_map_keyframe.translation_m;
    if (!IsDrivenWithin(window, stream, p_map)) continue;
    std::vector<MapPoint>& points = map.keyframes[i].points;
    std::erase_if(points, [&](const MapPoint&) { return is_replaced(random); });
    for (const MapPoint& other : original[(i + count / 2) % count].points) {
      if (is_replaced(random)) points.push_back(Mirrored(other));
    }
  }
  Replace(map, stream);
}

void RemoveStreet(Stream& stream, const Window& window) {
  EditableMap map = ToEditable(*stream.map);
  const Eigen::Vector3d origin_m = map.Origin_m();
  std::erase_if(map.keyframes, [&](const EditableKeyframe& keyframe) {
    return IsDrivenWithin(window, stream, PoseOf(keyframe.record).translation_m + origin_m);
  });
  Replace(map, stream);
}

std::vector<Fault> MapFaults() {
  return {MakeMapFault("other", "map of another street", 0.0, std::nullopt, 1.0),
          MakeMapFault("other-ahead", "map of another street from there on", Fault::kBegin_s,
                       std::nullopt, 1.0),
          MakeMapFault("other-10s", "map of another street for 10 s", Fault::kBegin_s, 10.0, 1.0),
          MakeMapFault("half-other", "half of the landmarks are of another street", 0.0,
                       std::nullopt, 0.5),
          MakeMapFault("half-other-10s", "half of the landmarks are of another street for 10 s",
                       Fault::kBegin_s, 10.0, 0.5),
          MakeGap("gap-10s", "the map has a gap of 10 s", 10.0),
          MakeGap("gap-30s", "the map has a gap of 30 s", 30.0)};
}

}  // namespace dcloc::faults
