#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "client/evaluation/outcome.h"

namespace dcloc::paper {

/// What the study's tables and figures need of an outcome: states, poses, errors, times, speed
/// differences; no covariances, no qualities, no map.
nlohmann::json OutcomeToJson(const DriveOutcome& outcome);

/// The inverse; nothing where `json` is not what `OutcomeToJson` writes.
std::optional<DriveOutcome> OutcomeFromJson(const nlohmann::json& json);

}  // namespace dcloc::paper
