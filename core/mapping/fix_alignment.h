#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/mapping/survey_graph_solver.h"

namespace dcloc {

/// The pose of the nodes' frame in the frame of the fixes that brings most of them together:
/// candidates come of pairs of fixes, so that many wrong ones (multipath) do no harm. A fix agrees
/// within three deviations and `slack_m`, by which the nodes may be bent. Nothing where fewer than
/// `kMinAgreeingFixes` agree or where those that do lie within `kMinFixSpread_m`, so that they say
/// little of the heading.
inline constexpr std::size_t kMinAgreeingFixes = 5;
inline constexpr double kMinFixSpread_m = 30.0;
std::optional<Pose2> AlignWithFixes(std::span<const Pose2> T_nodes, std::span<const NodeFix> fixes,
                                    double slack_m);

}  // namespace dcloc
