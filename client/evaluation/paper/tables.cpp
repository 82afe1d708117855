#include "client/evaluation/paper/tables.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/metrics_format.h"

namespace dcloc::paper {
namespace {

using nlohmann::ordered_json;

std::string Fixed(double value, int digits) {
  return std::isfinite(value) ? absl::StrFormat("%.*f", digits, value) : "-";
}

std::string Two(double a, double b, int digits) {
  return absl::StrCat(Fixed(a, digits), " / ", Fixed(b, digits));
}

std::string SlopeText(const Slope& slope) {
  if (!std::isfinite(slope.m_per_mps)) return "-";
  return absl::StrFormat("%+.2f [%+.2f, %+.2f]", kCmPerM * slope.m_per_mps, kCmPerM * slope.low,
                         kCmPerM * slope.high);
}

const char* ProtocolName(Protocol protocol) {
  return protocol == Protocol::kTrack ? "track" : "pairs";
}

std::vector<std::string> PrintedCells(const std::optional<Printed>& printed) {
  if (!printed) return {"", "", "", ""};
  return {Two(printed->rte_mean_m, printed->rte_median_m, 3),
          Two(printed->rre_mean_deg, printed->rre_median_deg, 3),
          Fixed(printed->success_percent, 1), printed->time_ms ? Fixed(*printed->time_ms, 1) : ""};
}

std::vector<std::string> RowText(const ComparisonRow& row) {
  std::vector<std::string> cells = {row.plan.label};
  for (std::string& cell : PrintedCells(row.plan.printed)) cells.push_back(std::move(cell));
  const Metrics& common = row.common;
  const Metrics& all = row.all;
  cells.insert(
      cells.end(),
      {Two(common.rte_m.mean, common.rte_m.median, 3),
       Two(common.rre_deg.mean, common.rre_deg.median, 3),
       absl::StrCat(Two(all.rte_m.mean, all.rte_m.median, 3), " / ", Fixed(all.rte_m.p95, 3)),
       absl::StrCat(Two(all.rre_deg.mean, all.rre_deg.median, 3), " / ", Fixed(all.rre_deg.p95, 3)),
       Fixed(100.0 * all.success_rate_all, 1), Fixed(all.anees, 2),
       Two(100.0 * all.coverage_95, 100.0 * all.coverage_999, 1),
       absl::StrCat(all.misleading_count), SlopeText(row.slope), Fixed(all.total_ms.mean, 2),
       absl::StrCat(common.scan_count, " of ", all.scan_count)});
  return cells;
}

ordered_json ToJson(const ComparisonRow& row) {
  ordered_json json = {{"label", row.plan.label}, {"variant", VariantName(row.plan.variant)}};
  if (row.plan.printed) {
    const Printed& printed = *row.plan.printed;
    json["paper"] = {{"rte_mean_m", printed.rte_mean_m},
                     {"rte_median_m", printed.rte_median_m},
                     {"rre_mean_deg", printed.rre_mean_deg},
                     {"rre_median_deg", printed.rre_median_deg},
                     {"success_percent", printed.success_percent}};
    if (printed.time_ms) json["paper"]["time_ms"] = *printed.time_ms;
  }
  json["where_all_succeed"] = MetricsJson(row.common);
  json["over_all"] = MetricsJson(row.all);
  if (std::isfinite(row.slope.m_per_mps)) {
    json["slope"] = {{"m_per_mps", row.slope.m_per_mps},
                     {"low", row.slope.low},
                     {"high", row.slope.high},
                     {"answers", row.slope.answer_count}};
  }
  return json;
}

void AddTable(std::span<const RunResult> results, StudyTable table, std::vector<RowPlan> rows,
              std::vector<StudyTable>& tables) {
  auto comparison = Compare(results, table.set, table.protocol, std::move(rows));
  if (!comparison) return;
  table.rows = *std::move(comparison);
  tables.push_back(std::move(table));
}

// Sets whose ablations stand in one table.
std::vector<std::string> AblationSets(std::span<const RunResult> results) {
  std::vector<std::string> sets;
  for (const std::string& set : SetsOf(results)) {
    if (absl::StartsWith(set, "noise ")) continue;
    const std::string joint = absl::StartsWith(set, "simulated ") ? "simulated" : set;
    if (sets.empty() || sets.back() != joint) sets.push_back(joint);
  }
  return sets;
}

const Variant& VariantOf(const ComparisonRow& row) { return row.plan.variant; }

// Ours in a Table I, as the rig is described; nullptr in other tables.
const ComparisonRow* Ours(const StudyTable& table) {
  if (table.id != "table-1") return nullptr;
  const auto ours = std::ranges::find(table.rows, Variant{}, VariantOf);
  return ours == table.rows.end() ? nullptr : &*ours;
}

}  // namespace

std::vector<StudyTable> StudyTables(std::span<const RunResult> results) {
  std::vector<StudyTable> tables;
  for (const std::string& set : SetsOf(results)) {
    if (absl::StartsWith(set, "noise ")) continue;
    AddTable(results, {"table-1", "Table I, each drive as one session", set, Protocol::kTrack, {}},
             Table1Rows(), tables);
    AddTable(results,
             {"table-1", "Table I, separate queries with a prior each", set, Protocol::kPairs, {}},
             Table1Rows(), tables);
  }
  for (const std::string& set : AblationSets(results)) {
    AddTable(results,
             {"table-2", "Table II, DC-Loc++ without its parts", set, Protocol::kTrack, {}},
             Table2Rows(MethodKind::kDcLocPlusPlus), tables);
    AddTable(results, {"table-2", "Table II, dcloc without its parts", set, Protocol::kTrack, {}},
             Table2Rows(MethodKind::kDcloc), tables);
    AddTable(results, {"table-3", "Table III, dcloc by scans a sub-map", set, Protocol::kTrack, {}},
             Table3Rows(), tables);
  }
  for (const std::string& set : SetsOf(results)) {
    if (!absl::StartsWith(set, "noise ")) continue;
    AddTable(results, {"table-4", "Table IV and Fig. 11", set, Protocol::kTrack, {}}, NoiseRows(),
             tables);
  }
  return tables;
}

const ComparisonRow* BestOther(const Comparison& rows,
                               const std::function<double(const Metrics&)>& measure) {
  const ComparisonRow* best = nullptr;
  for (const ComparisonRow& row : rows) {
    if (row.plan.variant.method == MethodKind::kDcloc || !std::isfinite(measure(row.all))) continue;
    if (best == nullptr || measure(row.all) < measure(best->all)) best = &row;
  }
  return best;
}

TextTable ComparisonText(const Comparison& rows) {
  TextTable table = {
      {"", "paper: RTE mean / median [m]", "paper: RRE mean / median [deg]", "paper: success [%]",
       "paper: time [ms]", "where all succeed: RTE mean / median",
       "where all succeed: RRE mean / median", "all: RTE mean / median / p95",
       "all: RRE mean / median / p95", "success [%]", "ANEES", "in 95 % / 99.9 % ellipsoid [%]",
       "misleading", "slope [cm per m/s], 95 % interval", "mean time [ms]", "scans"}};
  for (const ComparisonRow& row : rows) table.push_back(RowText(row));
  return table;
}

ordered_json ToJson(const StudyTable& table) {
  ordered_json rows = ordered_json::array();
  for (const ComparisonRow& row : table.rows) rows.push_back(ToJson(row));
  return {{"id", table.id},
          {"heading", table.heading},
          {"set", table.set},
          {"protocol", ProtocolName(table.protocol)},
          {"rows", std::move(rows)}};
}

TextTable SummaryText(std::span<const StudyTable> tables) {
  struct Measure {
    const char* name;
    int digits;
    std::function<double(const Metrics&)> of;
  };
  const std::vector<Measure> measures = {
      {"RTE median [m]", 3, [](const Metrics& m) { return m.rte_m.median; }},
      {"RTE mean [m]", 3, [](const Metrics& m) { return m.rte_m.mean; }},
      {"RTE p95 [m]", 3, [](const Metrics& m) { return m.rte_m.p95; }},
      {"RRE median [deg]", 3, [](const Metrics& m) { return m.rre_deg.median; }},
      {"mean time [ms]", 2, [](const Metrics& m) { return m.total_ms.mean; }}};
  TextTable text = {{"set", "protocol"}};
  for (const Measure& measure : measures) {
    text.front().push_back(absl::StrCat(measure.name, ": ours; best other; ratio"));
  }
  text.front().emplace_back("success [%]: ours; best other");
  for (const StudyTable& table : tables) {
    const ComparisonRow* row = Ours(table);
    if (row == nullptr) continue;
    const Metrics& ours = row->all;
    std::vector<std::string>& cells = text.emplace_back();
    cells = {table.set, ProtocolName(table.protocol)};
    for (const Measure& measure : measures) {
      const ComparisonRow* best = BestOther(table.rows, measure.of);
      const double other =
          best == nullptr ? std::numeric_limits<double>::quiet_NaN() : measure.of(best->all);
      cells.push_back(absl::StrCat(Fixed(measure.of(ours), measure.digits), "; ",
                                   Fixed(other, measure.digits),
                                   best == nullptr ? "" : " (" + best->plan.label + ")", "; ",
                                   Fixed(measure.of(ours) / other, 2)));
    }
    const auto failures = [](const Metrics& m) { return -m.success_rate_all; };
    const ComparisonRow* best = BestOther(table.rows, failures);
    cells.push_back(
        absl::StrCat(Fixed(100.0 * ours.success_rate_all, 1), "; ",
                     best == nullptr ? "-" : Fixed(100.0 * best->all.success_rate_all, 1)));
  }
  return text;
}

TextTable NoiseReductionText(std::span<const StudyTable> tables) {
  TextTable text = {{"noise", "paper: DC-Loc++ below MC-RANSAC; DC-Loc [%]",
                     "here: DC-Loc++ below MC-RANSAC; DC-Loc [%]",
                     "here: dcloc below MC-RANSAC; DC-Loc; DC-Loc++ [%]"}};
  std::size_t noise = 0;
  for (const StudyTable& table : tables) {
    if (table.id != "table-4" || noise == kFigure11.size()) continue;
    const auto mean_m = [&](MethodKind method) {
      const auto row = std::ranges::find(table.rows, Variant{.method = method}, VariantOf);
      return row == table.rows.end() ? std::numeric_limits<double>::quiet_NaN()
                                     : row->common.rte_m.mean;
    };
    const auto below = [&](MethodKind a, MethodKind b) {
      return Fixed(100.0 * (1.0 - mean_m(a) / mean_m(b)), 1);
    };
    const NoiseRow& printed = kFigure11.at(noise++);
    text.push_back({table.set,
                    absl::StrCat(Fixed(printed.below_mc_ransac_percent, 1), "; ",
                                 Fixed(printed.below_dc_loc_percent, 1)),
                    absl::StrCat(below(MethodKind::kDcLocPlusPlus, MethodKind::kMcRansac), "; ",
                                 below(MethodKind::kDcLocPlusPlus, MethodKind::kDcLoc)),
                    absl::StrCat(below(MethodKind::kDcloc, MethodKind::kMcRansac), "; ",
                                 below(MethodKind::kDcloc, MethodKind::kDcLoc), "; ",
                                 below(MethodKind::kDcloc, MethodKind::kDcLocPlusPlus))});
  }
  return text;
}

TextTable TimesText(std::span<const StudyTable> tables) {
  TextTable text = {{"set", "method", "Doppler compensation and sub-map [ms]", "registration [ms]",
                     "pose graph [ms]", "total [ms]"}};
  text.push_back({"paper", "DC-Loc++", Fixed(kCompensation_ms, 1), Fixed(kRegistration_ms, 1),
                  Fixed(kPoseGraph_ms, 1), Fixed(kTotal_ms, 1)});
  for (const StudyTable& table : tables) {
    if (table.id != "table-1" || table.protocol != Protocol::kTrack) continue;
    for (const ComparisonRow& row : table.rows) {
      if (row.plan.variant != Variant{} &&
          row.plan.variant != Variant{.method = MethodKind::kDcLocPlusPlus}) {
        continue;
      }
      const auto& stages = row.all.stage_ms;
      text.push_back({table.set, row.plan.label, Fixed(stages[0].mean + stages[1].mean, 2),
                      Fixed(stages[2].mean, 2), Fixed(stages[3].mean, 2),
                      Fixed(row.all.total_ms.mean, 2)});
    }
  }
  return text;
}

}  // namespace dcloc::paper
