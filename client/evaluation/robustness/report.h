#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/evaluation/robustness/campaign.h"
#include "client/evaluation/robustness/cells.h"
#include "client/evaluation/robustness/goals.h"

namespace dcloc::robustness {

/// Whole drives, a row for each of kRows that has results; by site below it where `by_site`.
TextTable TrackText(std::span<const TrialResult> results, bool by_site);

/// Starts likewise.
TextTable StartText(std::span<const TrialResult> results, bool by_site);

/// What `JudgeGoals` gave, with "met" or "missed".
TextTable GoalText(std::span<const GoalResult> goals);

/// Everything: rows, sites, goals, incidents.
nlohmann::ordered_json CampaignJson(std::span<const TrialResult> results);

/// The same as a self-contained page, but for the incidents.
std::string CampaignHtml(std::span<const TrialResult> results,
                         const std::vector<std::pair<std::string, std::string>>& settings);

}  // namespace dcloc::robustness
