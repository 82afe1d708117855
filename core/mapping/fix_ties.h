#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mapping/survey.h"
#include "core/mapping/survey_graph.h"

namespace dcloc {

/// Each fix at the node before it, where the vehicle was then by ego-motion. Those outside of the
/// drives' time are left out. `track_of` has, for each drive of the graph, its number in the fixes.
std::vector<NodeFix> TieFixes(std::span<const SurveyFix> fixes,
                              const std::vector<std::size_t>& track_of, const SurveyGraph& graph);

}  // namespace dcloc
