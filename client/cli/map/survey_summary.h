#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "client/cli/map/survey_judge.h"
#include "client/trajectory/trajectory.h"
#include "core/mapping/survey_builder.h"

namespace dcloc::cli {

/// What a survey found: for scripts, and for people.
nlohmann::ordered_json SurveyJson(const SurveyBuilder& builder,
                                  const std::optional<SurveyJudgement>& judgement);
std::string SurveyText(const SurveyBuilder& builder,
                       const std::optional<SurveyJudgement>& judgement);

/// The poses of all scans of a drive that is in the map.
Trajectory TrajectoryOf(const DriveTrack& track, const SurveyedDrive& drive);

}  // namespace dcloc::cli
