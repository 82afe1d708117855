#include "client/evaluation/paper/comparison.h"

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/match.h"

namespace dcloc::paper {
namespace {

constexpr const char* kAllSimulated = "simulated";

bool IsOfSet(const RunResult& result, const std::string& set) {
  return result.set == set || (set == kAllSimulated && absl::StartsWith(result.set, set));
}

}  // namespace

std::vector<std::string> SetsOf(std::span<const RunResult> results) {
  std::vector<std::string> sets;
  for (const RunResult& result : results) {
    if (std::ranges::find(sets, result.set) == sets.end()) sets.push_back(result.set);
  }
  return sets;
}

std::vector<const RunResult*> ResultsOf(std::span<const RunResult> results, const std::string& set,
                                        const Variant& variant, Protocol protocol) {
  std::vector<const RunResult*> found;
  for (const RunResult& result : results) {
    if (IsOfSet(result, set) && result.variant == variant && result.protocol == protocol) {
      found.push_back(&result);
    }
  }
  return found;
}

std::optional<Comparison> Compare(std::span<const RunResult> results, const std::string& set,
                                  Protocol protocol, std::vector<RowPlan> plans) {
  std::erase_if(plans, [&](const RowPlan& plan) {
    return ResultsOf(results, set, plan.variant, protocol).empty();
  });
  if (plans.size() < 2) return std::nullopt;
  std::map<std::string, std::vector<const DriveOutcome*>> by_case;  // one outcome a row
  for (const RowPlan& plan : plans) {
    for (const RunResult* result : ResultsOf(results, set, plan.variant, protocol)) {
      by_case[result->case_name].push_back(&result->outcome);
    }
  }
  std::vector<std::vector<DriveOutcome>> common(plans.size());
  std::vector<std::vector<DriveOutcome>> all(plans.size());
  for (const auto& [name, outcomes] : by_case) {
    if (outcomes.size() != plans.size()) continue;  // not every row's variant ran this case
    std::vector<DriveOutcome> kept = CommonSuccesses(outcomes);
    for (std::size_t row = 0; row < plans.size(); ++row) {
      common[row].push_back(std::move(kept[row]));
      all[row].push_back(*outcomes[row]);
    }
  }
  if (all.front().empty()) return std::nullopt;
  Comparison comparison;
  for (std::size_t row = 0; row < plans.size(); ++row) {
    comparison.push_back({.plan = std::move(plans[row]),
                          .common = ComputeMetrics(common[row]),
                          .all = ComputeMetrics(all[row]),
                          .slope = ErrorSlope(all[row])});
  }
  return comparison;
}

}  // namespace dcloc::paper
