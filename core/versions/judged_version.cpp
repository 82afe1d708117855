#include "core/versions/judged_version.h"

#include <algorithm>
#include <utility>

#include "core/versions/street_segments.h"

namespace dcloc {
namespace {

constexpr int kMaxRounds = 3;  // of leaving new streets out; each takes two replays

/// The old version, and of the new one the keyframes that are kept.
EditableMap WithNewStreets(const EditableMap& old_version, const EditableMap& new_version,
                           const std::vector<bool>& is_kept) {
  EditableMap map = new_version;
  map.keyframes = old_version.keyframes;
  for (std::size_t k = old_version.keyframes.size(); k < is_kept.size(); ++k) {
    if (is_kept[k]) map.keyframes.push_back(new_version.keyframes[k]);
  }
  return map;
}

/// Keeps no keyframe of a new street that is refused; false where there was none.
bool LeaveOutRefused(const EditableMap& judged, const UpdateEvaluation& evaluation,
                     const UpdateGateOptions& options, std::size_t old_count,
                     std::vector<bool>& is_kept) {
  const StreetSegments segments(judged, options.segment_m);
  bool has_left_out = false;
  std::size_t number = old_count;  // in the judged version
  for (std::size_t k = old_count; k < is_kept.size(); ++k) {
    if (!is_kept[k]) continue;
    if (evaluation.segments[segments.OfKeyframe(number++)].fault.empty()) continue;
    is_kept[k] = false;
    has_left_out = true;
  }
  return has_left_out;
}

}  // namespace

absl::StatusOr<JudgedVersion> JudgeVersion(const EditableMap& old_version, const MapUpdate& update,
                                           const Rig& rig, const std::vector<Scan>& scans,
                                           const UpdateGateOptions& options) {
  const EditableMap& new_version = update.map;
  const std::vector<Eigen::Vector2d> intermittent_m = IntermittentPlaces(update);
  auto evaluation = EvaluateUpdate(old_version, new_version, rig, scans, intermittent_m, options);
  if (!evaluation.ok()) return evaluation.status();
  const std::size_t old_count = old_version.keyframes.size();
  JudgedVersion version{.map = new_version,
                        .evaluation = *std::move(evaluation),
                        .is_kept = std::vector<bool>(new_version.keyframes.size(), true)};
  if (version.evaluation.is_better || new_version.keyframes.size() <= old_count) return version;
  version.has_only_new_streets = true;
  std::fill_n(version.is_kept.begin(), old_count, false);
  for (int round = 0; round < kMaxRounds; ++round) {
    version.map = WithNewStreets(old_version, new_version, version.is_kept);
    evaluation = EvaluateUpdate(old_version, version.map, rig, scans, intermittent_m, options);
    if (!evaluation.ok()) return evaluation.status();
    version.evaluation = *std::move(evaluation);
    if (version.evaluation.is_better) break;
    if (!LeaveOutRefused(version.map, version.evaluation, options, old_count, version.is_kept)) {
      break;
    }
  }
  return version;
}

std::vector<Eigen::Vector2d> IntermittentPlaces(const MapUpdate& update) {
  std::vector<Eigen::Vector2d> places_m;
  for (const auto* const landmarks : {&update.known, &update.found}) {
    for (const LandmarkHistory& landmark : *landmarks) {
      if (landmark.fate != LandmarkFate::kIntermittent) continue;
      places_m.push_back((landmark.p_map_m - update.map.Origin_m()).head<2>());
    }
  }
  return places_m;
}

}  // namespace dcloc
