#pragma once

#include <optional>
#include <span>
#include <string>

#include "client/evaluation/gnuplot.h"
#include "client/evaluation/paper/study.h"

namespace dcloc::paper {

/// Fig. 9: mean errors of all methods by the speed difference to the map, over the answers of a set
/// that succeeded. Nothing when no speed difference has enough answers.
std::optional<Picture> DrawSpeedFigure(std::span<const RunResult> results, const std::string& set);

/// Fig. 10: the errors' distribution, 5, 25, 50, 75 and 95 %.
std::optional<Picture> DrawDistributionFigure(std::span<const RunResult> results,
                                              const std::string& set);

/// Fig. 11: median errors by speed difference for each noise model, of the sets "noise ...".
std::optional<Picture> DrawNoiseFigure(std::span<const RunResult> results);

/// Fig. 12: the longest track of a set, and close-ups where the paper's methods are worst.
std::optional<Picture> DrawTrackFigure(std::span<const RunResult> results, const std::string& set);

}  // namespace dcloc::paper
