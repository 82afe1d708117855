#pragma once

#include <span>
#include <string>
#include <vector>

#include "client/evaluation/robustness/campaign.h"

namespace dcloc::robustness {

/// The trials of a row at all sites as one.
Tally TallyOf(std::span<const TrialResult> results, const std::string& row);

/// A goal of the project's and where it stands.
struct GoalResult {
  std::string goal;
  std::string measured;
  bool is_met = false;
};

/// The goals that there are results for.
std::vector<GoalResult> JudgeGoals(std::span<const TrialResult> results);

}  // namespace dcloc::robustness
