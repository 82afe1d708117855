#include "core/update/street_by_street.h"

#include <utility>

namespace dcloc {
namespace {

constexpr int kMaxRounds = 3;  // of leaving segments out; each takes two replays

/// Marks the segments that are worse; false where there is none that was not left already.
bool MarkWorse(const UpdateEvaluation& evaluation, VersionByStreet& version) {
  bool has_marked = false;
  for (std::size_t i = 0; i < evaluation.segments.size(); ++i) {
    if (evaluation.segments[i].fault.empty() || version.is_left[i]) continue;
    version.is_left[i] = true;
    ++version.left_count;
    has_marked = true;
  }
  return has_marked;
}

void LeaveAsItWas(const EditableMap& old_version, VersionByStreet& version) {
  for (std::size_t k = 0; k < version.map.keyframes.size(); ++k) {
    if (!version.is_left[version.segments.OfKeyframe(k)]) continue;
    if (k < old_version.keyframes.size()) {
      version.map.keyframes[k] = old_version.keyframes[k];
    } else {
      version.map.keyframes[k].points.clear();
    }
  }
}

/// New keyframes of segments that were left.
void RemoveEmptyStreets(const EditableMap& old_version, VersionByStreet& version) {
  std::size_t k = 0;
  std::erase_if(version.map.keyframes, [&](const EditableKeyframe&) {
    const std::size_t keyframe = k++;
    return keyframe >= old_version.keyframes.size() &&
           version.is_left[version.segments.OfKeyframe(keyframe)];
  });
}

}  // namespace

absl::StatusOr<VersionByStreet> JudgeStreetByStreet(const EditableMap& old_version,
                                                    const EditableMap& new_version, const Rig& rig,
                                                    const std::vector<Scan>& scans,
                                                    const UpdateGateOptions& options) {
  auto evaluation = EvaluateUpdate(old_version, new_version, rig, scans, options);
  if (!evaluation.ok()) return evaluation.status();
  VersionByStreet version{.map = new_version,
                          .evaluation = {},
                          .segments = StreetSegments(new_version, options.segment_m),
                          .is_left = {}};
  version.is_left.resize(version.segments.count(), false);
  for (int round = 0; round < kMaxRounds && !evaluation->is_better; ++round) {
    if (!MarkWorse(*evaluation, version)) break;
    LeaveAsItWas(old_version, version);
    evaluation = EvaluateUpdate(old_version, version.map, rig, scans, options);
    if (!evaluation.ok()) return evaluation.status();
  }
  version.evaluation = *std::move(evaluation);
  RemoveEmptyStreets(old_version, version);
  return version;
}

}  // namespace dcloc
