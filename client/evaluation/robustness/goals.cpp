#include "client/evaluation/robustness/goals.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/robustness/judgement.h"

namespace dcloc::robustness {
namespace {

constexpr double kRightShare = 0.999;
constexpr std::size_t kMisleadingScans = 100'000;
constexpr double kStartShare = 0.99;
constexpr double kMinAnees = 0.8, kMaxAnees = 1.25;
constexpr double kMinCoverage = 0.93, kMaxCoverage = 0.97;

Tally SumOf(std::span<const TrialResult> results, bool (*takes)(const Row&)) {
  Tally sum;
  for (const Row& row : kRows) {
    if (takes(row)) Merge(TallyOf(results, row.id), sum);
  }
  return sum;
}

bool IsSimulatedDrive(const Row& row) { return !row.is_start && !row.is_recorded; }

void AddRightGoal(const Tally& drives, std::vector<GoalResult>& goals) {
  if (drives.scans == 0) return;
  const double share = static_cast<double>(drives.right) / static_cast<double>(drives.scans);
  goals.push_back({"simulated drives: >= 99.9 % right, the rest flagged",
                   absl::StrFormat("%.3f %% of %d right, %d flagged, %d wrong", 100.0 * share,
                                   drives.scans, drives.flagged, drives.wrong),
                   share >= kRightShare && drives.wrong == 0});
}

void AddMisleadingGoal(const Tally& all, std::vector<GoalResult>& goals) {
  goals.push_back({"everything: no misleading answer in 100,000 scans",
                   absl::StrFormat("%d in %d", all.misleading, all.scans),
                   all.misleading == 0 && all.scans >= kMisleadingScans});
}

void AddRecoveryGoal(const Row& row, const Tally& tally, std::vector<GoalResult>& goals) {
  if (tally.episodes == 0) return;
  const double share = ShareWithin(tally.recovery_s, tally.episodes, kRecoveryGoal_s);
  goals.push_back({absl::StrCat(row.label, ": tracking again within 1 s"),
                   absl::StrFormat("%.1f %% of %d", 100.0 * share, tally.episodes), share == 1.0});
}

void AddStartGoal(const Row& row, const Tally& tally, std::vector<GoalResult>& goals) {
  if (tally.starts == 0) return;
  const double share = ShareWithin(tally.right_claim_s, tally.starts, kStartGoal_s);
  goals.push_back(
      {absl::StrCat(row.label, ": >= 99 % right within 2 s, no wrong claim"),
       absl::StrFormat("%.1f %% of %d, %d wrong", 100.0 * share, tally.starts, tally.wrong_claims),
       share >= kStartShare && tally.wrong_claims == 0});
}

void AddCovarianceGoal(const std::string& where, double nees_per_dof_sum, std::size_t nees_count,
                       std::size_t inside_95, std::vector<GoalResult>& goals) {
  if (nees_count == 0) return;
  const double anees = nees_per_dof_sum / static_cast<double>(nees_count);
  const double coverage = static_cast<double>(inside_95) / static_cast<double>(nees_count);
  goals.push_back({absl::StrCat(where, ": ANEES 0.8 - 1.25, 93 - 97 % in the 95 % ellipsoid"),
                   absl::StrFormat("%.2f, %.1f %%", anees, 100.0 * coverage),
                   anees >= kMinAnees && anees <= kMaxAnees && coverage >= kMinCoverage &&
                       coverage <= kMaxCoverage});
}

void AddCovarianceGoals(const Row& row, const Tally& tally, std::vector<GoalResult>& goals) {
  AddCovarianceGoal(row.label, tally.nees_per_dof_sum, tally.nees_count, tally.inside_95, goals);
  AddCovarianceGoal(absl::StrCat(row.label, ", meanwhile"), tally.disturbed_nees_per_dof_sum,
                    tally.disturbed_nees_count, tally.disturbed_inside_95, goals);
}

}  // namespace

Tally TallyOf(std::span<const TrialResult> results, const std::string& row) {
  Tally sum;
  for (const TrialResult& result : results) {
    if (result.row == row) Merge(result.tally, sum);
  }
  return sum;
}

std::vector<GoalResult> JudgeGoals(std::span<const TrialResult> results) {
  std::vector<GoalResult> goals;
  AddRightGoal(SumOf(results, IsSimulatedDrive), goals);
  AddMisleadingGoal(SumOf(results, [](const Row&) { return true; }), goals);
  for (const Row& row : kRows) {
    const Tally tally = TallyOf(results, row.id);
    AddRecoveryGoal(row, tally, goals);
    AddStartGoal(row, tally, goals);
    if (!row.is_start) AddCovarianceGoals(row, tally, goals);
  }
  return goals;
}

}  // namespace dcloc::robustness
