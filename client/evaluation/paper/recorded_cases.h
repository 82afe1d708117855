#pragma once

#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/paper/study.h"

namespace dcloc::paper {

/// The cases of the recordings in `folder`, which is a nuScenes or RadarScenes root or holds such.
/// nuScenes: the front radar of every revisit of a place by another scene, as in the paper; where
/// no scene revisits another, the rear radars of each scene in a map of its front ones.
/// RadarScenes: the side radars of each sequence in a map of its front ones.
/// NotFound when there is neither data set; DataLoss names a broken file.
absl::StatusOr<std::vector<Case>> RecordedCases(const std::filesystem::path& folder);

}  // namespace dcloc::paper
