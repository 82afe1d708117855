#include "client/evaluation/robustness/report.h"

#include <functional>

#include "absl/strings/str_cat.h"
#include "client/evaluation/html.h"
#include "client/evaluation/robustness/cells.h"
#include "client/evaluation/robustness/judgement.h"

namespace dcloc::robustness {
namespace {

using nlohmann::ordered_json;

constexpr const char* kReading =
    "Right is an answer within 2 m and 5 degrees, in whatever state; flagged is one that is not, "
    "and that the localizer does not call tracking; wrong is one that is not and that it does. "
    "Misleading is a wrong one outside of its own 99.9 % ellipsoid. Scans before the first answer, "
    "as far as they lie within the first 2 s, are a start and not counted. Back is the time from "
    "the first scan after a disturbance to the first from which on every scan of a second is "
    "tracking and right. Starts are separate sessions; their time is the data until the first "
    "answer that is called tracking.";

double Anees(const Tally& tally) { return Mean(tally.nees_per_dof_sum, tally.nees_count); }

double DisturbedAnees(const Tally& tally) {
  return Mean(tally.disturbed_nees_per_dof_sum, tally.disturbed_nees_count);
}

std::vector<std::string> TrackCells(const std::string& label, const Tally& tally) {
  return {label,
          absl::StrCat(tally.scans),
          Fixed(100.0 * Share(tally.right, tally.scans), 2),
          absl::StrCat(tally.flagged),
          absl::StrCat(tally.wrong),
          absl::StrCat(tally.misleading),
          absl::StrCat(tally.episodes),
          ThreeQuantiles(tally.recovery_s, tally.episodes),
          Fixed(100.0 * ShareWithin(tally.recovery_s, tally.episodes, kRecoveryGoal_s), 1),
          Fixed(tally.worst_tracking_m, 2),
          Fixed(Anees(tally), 2),
          Fixed(100.0 * Share(tally.inside_95, tally.nees_count), 1),
          Fixed(DisturbedAnees(tally), 2),
          Fixed(100.0 * Share(tally.disturbed_inside_95, tally.disturbed_nees_count), 1)};
}

std::vector<std::string> StartCells(const std::string& label, const Tally& tally) {
  const std::size_t silent = tally.starts - tally.right_claim_s.size() - tally.wrong_claims;
  return {label,
          absl::StrCat(tally.starts),
          Fixed(100.0 * ShareWithin(tally.right_claim_s, tally.starts, kStartGoal_s), 1),
          Fixed(100.0 * Share(tally.right_claim_s.size(), tally.starts), 1),
          absl::StrCat(tally.wrong_claims),
          absl::StrCat(silent),
          ThreeQuantiles(tally.right_claim_s, tally.starts)};
}

using Cells = std::function<std::vector<std::string>(const std::string&, const Tally&)>;

void AddRows(std::span<const TrialResult> results, bool starts, bool by_site, const Cells& cells,
             TextTable& table) {
  for (const Row& row : kRows) {
    if (row.is_start != starts) continue;
    const Tally all = TallyOf(results, row.id);
    if (all.scans == 0) continue;
    table.push_back(cells(row.label, all));
    for (const TrialResult& result : results) {
      if (by_site && result.row == row.id) {
        table.push_back(cells("- " + result.site, result.tally));
      }
    }
  }
}

ordered_json Quantiles(const std::vector<double>& values, std::size_t count) {
  return {{"count", count},
          {"p50", Number(QuantileOf(values, count, 0.5))},
          {"p99", Number(QuantileOf(values, count, 0.99))},
          {"max", Number(QuantileOf(values, count, 1.0))}};
}

ordered_json Measures(const Tally& tally, bool is_start) {
  ordered_json json = {{"scans", tally.scans},
                       {"right_share", Number(Share(tally.right, tally.scans))},
                       {"flagged", tally.flagged},
                       {"wrong", tally.wrong},
                       {"misleading", tally.misleading},
                       {"refused", tally.refused},
                       {"worst_tracking_m", tally.worst_tracking_m},
                       {"anees", Number(Anees(tally))},
                       {"coverage_95", Number(Share(tally.inside_95, tally.nees_count))}};
  if (is_start) {
    json["starts"] = tally.starts;
    json["right_within_2_s_share"] =
        Number(ShareWithin(tally.right_claim_s, tally.starts, kStartGoal_s));
    json["wrong_claims"] = tally.wrong_claims;
    json["right_claim_s"] = Quantiles(tally.right_claim_s, tally.starts);
  } else {
    json["recovery_s"] = Quantiles(tally.recovery_s, tally.episodes);
    json["anees_disturbed"] = Number(DisturbedAnees(tally));
    json["coverage_95_disturbed"] =
        Number(Share(tally.disturbed_inside_95, tally.disturbed_nees_count));
    json["recovered_within_1_s_share"] =
        Number(ShareWithin(tally.recovery_s, tally.episodes, kRecoveryGoal_s));
  }
  return json;
}

ordered_json RowJson(const Row& row, std::span<const TrialResult> results) {
  ordered_json json = {{"id", row.id}, {"label", row.label}};
  json.update(Measures(TallyOf(results, row.id), row.is_start));
  json["sites"] = ordered_json::array();
  for (const TrialResult& result : results) {
    if (result.row != row.id) continue;
    ordered_json site = {{"site", result.site}};
    site.update(Measures(result.tally, row.is_start));
    site["incidents"] = TallyToJson(result.tally)["incidents"];
    json["sites"].push_back(std::move(site));
  }
  return json;
}

std::string Section(const std::string& heading, const TextTable& table) {
  if (table.size() < 2) return "";
  return absl::StrCat("<h2>", EscapeHtml(heading), "</h2>\n", HtmlTable(table));
}

}  // namespace

TextTable TrackText(std::span<const TrialResult> results, bool by_site) {
  TextTable table = {{"whole drives", "scans", "right [%]", "flagged", "wrong", "misleading",
                      "episodes", "back p50 / p99 / max [s]", "within 1 s [%]",
                      "worst tracking [m]", "ANEES", "in 95 % [%]", "ANEES in episodes",
                      "in 95 % [%]"}};
  AddRows(results, false, by_site, TrackCells, table);
  return table;
}

TextTable StartText(std::span<const TrialResult> results, bool by_site) {
  TextTable table = {{"starts", "sessions", "right within 2 s [%]", "in the end [%]",
                      "wrong claims", "no claim", "data p50 / p99 / max [s]"}};
  AddRows(results, true, by_site, StartCells, table);
  return table;
}

TextTable GoalText(std::span<const GoalResult> goals) {
  TextTable table = {{"goal", "measured", ""}};
  for (const GoalResult& goal : goals) {
    table.push_back({goal.goal, goal.measured, goal.is_met ? "met" : "missed"});
  }
  return table;
}

ordered_json CampaignJson(std::span<const TrialResult> results) {
  ordered_json rows = ordered_json::array();
  for (const Row& row : kRows) {
    if (TallyOf(results, row.id).scans > 0) rows.push_back(RowJson(row, results));
  }
  ordered_json goals = ordered_json::array();
  for (const GoalResult& goal : JudgeGoals(results)) {
    goals.push_back({{"goal", goal.goal}, {"measured", goal.measured}, {"met", goal.is_met}});
  }
  return {{"rows", std::move(rows)}, {"goals", std::move(goals)}};
}

std::string CampaignHtml(std::span<const TrialResult> results,
                         const std::vector<std::pair<std::string, std::string>>& settings) {
  std::string body = "<dl>\n";
  for (const auto& [name, value] : settings) {
    absl::StrAppend(&body, "<dt>", EscapeHtml(name), "</dt><dd>", EscapeHtml(value), "</dd>\n");
  }
  absl::StrAppend(&body, "</dl>\n<p>", EscapeHtml(kReading), "</p>\n",
                  Section("Goals", GoalText(JudgeGoals(results))),
                  Section("Whole drives", TrackText(results, true)),
                  Section("Starts", StartText(results, true)));
  return HtmlPage("Robustness", body);
}

}  // namespace dcloc::robustness
