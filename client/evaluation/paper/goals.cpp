#include "client/evaluation/paper/goals.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace dcloc::paper {
namespace {

struct AccuracyBounds {
  double rte_median_m, rte_p95_m, rre_median_deg;
};

// Of the sets that are driven through at all speeds.
std::optional<AccuracyBounds> AccuracyOf(const StudyTable& table) {
  if (table.protocol != Protocol::kTrack) return std::nullopt;
  if (table.set == "simulated ARS408, town") return AccuracyBounds{0.03, 0.10, 0.05};
  if (table.id == "table-4") return AccuracyBounds{0.05, 0.15, 0.10};
  return std::nullopt;
}

bool IsRecorded(const std::string& set) {
  return !absl::StartsWith(set, "simulated ") && !absl::StartsWith(set, "noise ");
}

std::string RowName(const std::string& set, Protocol protocol, const Variant& variant) {
  return absl::StrCat(set, protocol == Protocol::kTrack ? "; one session a drive" : "; queries",
                      variant.calibrated ? "; calibrated" : "; as described",
                      variant.far_prior ? "; from 3 m, 5 deg" : "");
}

void AddAccuracy(const AccuracyBounds& bounds, const std::string& set, const Metrics& metrics,
                 std::vector<Goal>& goals) {
  goals.push_back({"RTE median [m]", set, metrics.rte_m.median, 0.0, bounds.rte_median_m});
  goals.push_back({"RTE p95 [m]", set, metrics.rte_m.p95, 0.0, bounds.rte_p95_m});
  goals.push_back({"RRE median [deg]", set, metrics.rre_deg.median, 0.0, bounds.rre_median_deg});
}

// The median of the best of the others, which were told the same of the rig.
void AddRatio(const StudyTable& table, const std::string& set, const Metrics& metrics,
              std::vector<Goal>& goals) {
  const ComparisonRow* best =
      BestOther(table.rows, [](const Metrics& m) { return m.rte_m.median; });
  if (best == nullptr) return;
  goals.push_back({"RTE median by best other's", set, metrics.rte_m.median / best->all.rte_m.median,
                   0.0, 0.5, 2,
                   absl::StrFormat("%s %.3f", best->plan.label, best->all.rte_m.median)});
}

// A trend is none when its 95 % interval holds 0: the distance of the interval to 0.
void AddSlope(const Slope& slope, const std::string& set, std::vector<Goal>& goals) {
  if (!std::isfinite(slope.m_per_mps)) return;
  const double distance = std::max({0.0, slope.low, -slope.high});
  goals.push_back({"slope's interval to 0 [cm per m/s]", set, kCmPerM * distance, 0.0, 0.0, 2,
                   absl::StrFormat("[%+.2f, %+.2f]", kCmPerM * slope.low, kCmPerM * slope.high)});
}

void AddTrust(const std::string& set, const Metrics& metrics, std::vector<Goal>& goals) {
  goals.push_back({"success of answered [%]", set, 100.0 * metrics.success_rate, 99.9, 100.0, 2});
  goals.push_back({"misleading", set, static_cast<double>(metrics.misleading_count), 0.0, 0.0, 0,
                   absl::StrCat("of ", metrics.scan_count)});
  goals.push_back({"ANEES", set, metrics.anees, 0.8, 1.25, 2});
  goals.push_back({"in 95 % ellipsoid [%]", set, 100.0 * metrics.coverage_95, 93.0, 97.0, 1});
}

void AddGoalsOf(const StudyTable& table, std::vector<Goal>& goals) {
  for (const ComparisonRow& row : table.rows) {
    if (row.plan.variant.method != MethodKind::kDcloc) continue;
    const std::string set = RowName(table.set, table.protocol, row.plan.variant);
    if (const auto bounds = AccuracyOf(table)) AddAccuracy(*bounds, set, row.all, goals);
    if (!row.plan.variant.calibrated) AddRatio(table, set, row.all, goals);
    if (table.protocol == Protocol::kTrack) {
      if (!IsRecorded(table.set)) AddSlope(row.slope, set, goals);
      AddTrust(set, row.all, goals);
    }
  }
}

// Half of what point-to-line ICP reached on the recordings of the development split.
std::optional<double> RecordedBound(const std::string& set) {
  if (absl::StartsWith(set, "nuScenes, front")) return 0.147;
  if (absl::StartsWith(set, "RadarScenes, front")) return 0.218;
  return std::nullopt;
}

void AddRecorded(std::span<const RunResult> results, const std::string& set,
                 std::vector<Goal>& goals) {
  const auto bound = RecordedBound(set);
  if (!bound) return;
  for (const bool far_prior : {false, true}) {
    const Variant variant = {.calibrated = true, .far_prior = far_prior};
    std::vector<DriveOutcome> outcomes;
    for (const RunResult* result : ResultsOf(results, set, variant, Protocol::kPairs)) {
      outcomes.push_back(result->outcome);
    }
    if (outcomes.empty()) continue;
    const Metrics metrics = ComputeMetrics(outcomes);
    const std::string row = RowName(set, Protocol::kPairs, variant);
    goals.push_back({"RTE median [m]", row, metrics.rte_m.median, 0.0, *bound});
    AddTrust(row, metrics, goals);
  }
}

std::string BoundText(const Goal& goal) {
  if (goal.low == goal.high) return absl::StrFormat("= %g", goal.low);
  if (goal.low <= 0.0) return absl::StrFormat("<= %g", goal.high);
  return absl::StrFormat("%g - %g", goal.low, goal.high);
}

std::string CellText(const Goal& goal) {
  std::string text =
      std::isfinite(goal.value) ? absl::StrFormat("%.*f", goal.digits, goal.value) : "none";
  if (!goal.detail.empty()) absl::StrAppend(&text, " (", goal.detail, ")");
  return absl::StrCat(text, goal.met() ? ": met, " : ": NOT met, ", BoundText(goal));
}

nlohmann::ordered_json NumberJson(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

template <typename Container>
std::size_t IndexOf(Container& names, const std::string& name) {
  const auto found = std::ranges::find(names, name);
  const auto index = static_cast<std::size_t>(found - names.begin());
  if (found == names.end()) names.push_back(name);
  return index;
}

}  // namespace

std::vector<Goal> Goals(std::span<const RunResult> results, std::span<const StudyTable> tables) {
  std::vector<Goal> goals;
  for (const StudyTable& table : tables) {
    if (table.id == "table-1" || table.id == "table-4") AddGoalsOf(table, goals);
  }
  for (const std::string& set : SetsOf(results)) AddRecorded(results, set, goals);
  return goals;
}

TextTable GoalsText(std::span<const Goal> goals) {
  std::vector<std::string> columns = {"set"};
  std::vector<std::string> sets;
  TextTable text(1);
  for (const Goal& goal : goals) {
    const std::size_t column = IndexOf(columns, goal.what);
    const std::size_t row = 1 + IndexOf(sets, goal.set);
    if (row == text.size()) text.push_back({goal.set});
    if (text[row].size() <= column) text[row].resize(column + 1);
    text[row][column] = CellText(goal);
  }
  text.front() = columns;
  for (std::vector<std::string>& row : text) row.resize(columns.size());
  return text;
}

nlohmann::ordered_json GoalsJson(std::span<const Goal> goals) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Goal& goal : goals) {
    json.push_back({{"set", goal.set},
                    {"what", goal.what},
                    {"value", NumberJson(goal.value)},
                    {"low", NumberJson(goal.low)},
                    {"high", NumberJson(goal.high)},
                    {"detail", goal.detail},
                    {"met", goal.met()}});
  }
  return json;
}

}  // namespace dcloc::paper
