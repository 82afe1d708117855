#include "client/evaluation/faults/report.h"

#include "absl/strings/str_cat.h"
#include "client/evaluation/html.h"
#include "client/evaluation/metrics.h"

namespace dcloc::faults {
namespace {

using robustness::Fixed;
using robustness::Mean;
using robustness::Share;
using robustness::TextTable;
using robustness::ThreeQuantiles;

constexpr const char* kFaultReading =
    "Wrong is an answer that is called TRACKING and is more than 2 m or 5 degrees off; misleading "
    "is one that is called TRACKING, more than 2 m off, and outside of its own 99.9 % ellipsoid. "
    "Refused are scans that the localizer did not take. Tracking is over all answers, and over "
    "those while the fault lasts. Right again is the time from the fault's end to the first answer "
    "from which a whole second is TRACKING, within 2 m and within 5 degrees, over the cases; "
    "faults "
    "that stay to the end have none. Errors are over the answers with a pose in the map; "
    "undisturbed "
    "are the same drives without the fault. The longest call is wall clock, for information.";

std::string TwoErrors(const std::vector<double>& errors_m) {
  return absl::StrCat(Fixed(Quantile(errors_m, 0.5), 2), " / ", Fixed(Quantile(errors_m, 0.95), 2));
}

std::vector<std::string> FaultCells(const std::string& name, const FaultRow& row) {
  const Record& record = row.record;
  const robustness::Tally& tally = record.tally;
  return {name,
          absl::StrCat(record.cases),
          absl::StrCat(record.arrived),
          absl::StrCat(tally.refused),
          absl::StrCat(tally.wrong),
          absl::StrCat(tally.misleading),
          Fixed(100.0 * Share(tally.tracking, tally.scans), 1),
          Fixed(100.0 * Share(record.meanwhile_tracking, record.meanwhile_scans), 1),
          tally.episodes == 0 ? "-" : ThreeQuantiles(tally.recovery_s, tally.episodes),
          TwoErrors(record.errors_m),
          TwoErrors(row.undisturbed.errors_m),
          TwoErrors(record.meanwhile_errors_m),
          Fixed(tally.worst_tracking_m, 2),
          Fixed(Mean(tally.nees_per_dof_sum, tally.nees_count), 2),
          Fixed(record.longest_call_ms, 1),
          absl::StrCat(record.failures.size())};
}

}  // namespace

TextTable FaultText(std::span<const FaultRows> rows, bool by_kind) {
  TextTable table = {{"fault", "cases", "scans", "refused", "wrong", "misleading", "tracking [%]",
                      "meanwhile [%]", "right again p50 / p99 / max [s]", "error p50 / p95 [m]",
                      "undisturbed [m]", "meanwhile [m]", "worst tracking [m]", "ANEES",
                      "longest call [ms]", "failures"}};
  for (const FaultRows& fault : rows) {
    table.push_back(FaultCells(fault.all.name, fault.all));
    if (!by_kind) continue;
    for (const FaultRow& row : fault.by_kind) {
      table.push_back(FaultCells(absl::StrCat("- ", row.name), row));
    }
  }
  return table;
}

TextTable FailureText(std::span<const FaultRows> rows) {
  TextTable table = {{"failure", "world and what"}};
  for (const FaultRows& fault : rows) {
    for (const std::string& failure : fault.all.record.failures) {
      table.push_back({fault.all.name, failure});
    }
  }
  return table;
}

std::string FaultHtml(std::span<const FaultRows> rows,
                      const std::vector<std::pair<std::string, std::string>>& settings,
                      const std::string& stanford_svg, const std::string& stanford_remark) {
  std::string body = "<dl>\n";
  for (const auto& [name, value] : settings) {
    absl::StrAppend(&body, "<dt>", EscapeHtml(name), "</dt><dd>", EscapeHtml(value), "</dd>\n");
  }
  absl::StrAppend(&body, "</dl>\n<p>", EscapeHtml(kFaultReading), "</p>\n");
  const TextTable failures = FailureText(rows);
  if (failures.size() > 1) absl::StrAppend(&body, "<h2>Failures</h2>\n", HtmlTable(failures));
  absl::StrAppend(&body, "<h2>All worlds</h2>\n", HtmlTable(FaultText(rows, false)),
                  "<h2>Stanford diagram</h2>\n<p>", EscapeHtml(stanford_remark), "</p>\n",
                  stanford_svg.empty() ? "" : InlineSvg(stanford_svg), "<h2>By world</h2>\n",
                  HtmlTable(FaultText(rows, true)));
  return HtmlPage("Faults", body);
}

}  // namespace dcloc::faults
