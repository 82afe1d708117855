#include "client/evaluation/faults/report_json.h"

#include <utility>

#include "client/evaluation/metrics.h"
#include "client/evaluation/robustness/cells.h"

namespace dcloc::faults {
namespace {

using nlohmann::ordered_json;
using robustness::Mean;
using robustness::Number;
using robustness::QuantileOf;
using robustness::Share;

constexpr int kMaxIncidents = 20;  // of a session

ordered_json ErrorsJson(const std::vector<double>& errors_m) {
  return {{"count", errors_m.size()},
          {"p50", Number(Quantile(errors_m, 0.5))},
          {"p95", Number(Quantile(errors_m, 0.95))},
          {"max", Number(Quantile(errors_m, 1.0))}};
}

ordered_json RecordMeasures(const Record& record) {
  const robustness::Tally& tally = record.tally;
  ordered_json json = {{"cases", record.cases},
                       {"scans", record.arrived},
                       {"judged", tally.scans},
                       {"right", tally.right},
                       {"flagged", tally.flagged},
                       {"refused", tally.refused},
                       {"wrong", tally.wrong},
                       {"misleading", tally.misleading},
                       {"tracking_share", Number(Share(tally.tracking, tally.scans))},
                       {"tracking_share_meanwhile",
                        Number(Share(record.meanwhile_tracking, record.meanwhile_scans))},
                       {"recovery_s",
                        {{"count", tally.episodes},
                         {"p50", Number(QuantileOf(tally.recovery_s, tally.episodes, 0.5))},
                         {"p99", Number(QuantileOf(tally.recovery_s, tally.episodes, 0.99))},
                         {"max", Number(QuantileOf(tally.recovery_s, tally.episodes, 1.0))},
                         {"never", tally.episodes - tally.recovery_s.size()}}},
                       {"error_m", ErrorsJson(record.errors_m)},
                       {"error_meanwhile_m", ErrorsJson(record.meanwhile_errors_m)},
                       {"worst_tracking_m", tally.worst_tracking_m},
                       {"anees", Number(Mean(tally.nees_per_dof_sum, tally.nees_count))},
                       {"anees_meanwhile",
                        Number(Mean(tally.disturbed_nees_per_dof_sum, tally.disturbed_nees_count))},
                       {"coverage_95", Number(Share(tally.inside_95, tally.nees_count))},
                       {"longest_call_ms", record.longest_call_ms},
                       {"failures", record.failures}};
  if (record.stanford.answers > 0) json["stanford"] = StanfordToJson(record.stanford);
  return json;
}

ordered_json RowMeasures(const FaultRow& row) {
  ordered_json json = RecordMeasures(row.record);
  json["undisturbed_error_m"] = ErrorsJson(row.undisturbed.errors_m);
  return json;
}

}  // namespace

ordered_json FaultJson(std::span<const FaultRows> rows, std::span<const CaseResult> results) {
  ordered_json faults = ordered_json::array();
  for (const FaultRows& fault : rows) {
    ordered_json json = {{"id", fault.id}, {"family", fault.family}, {"label", fault.all.name}};
    json.update(RowMeasures(fault.all));
    json["kinds"] = ordered_json::array();
    for (const FaultRow& row : fault.by_kind) {
      ordered_json kind = {{"kind", row.name}};
      kind.update(RowMeasures(row));
      json["kinds"].push_back(std::move(kind));
    }
    json["worlds"] = ordered_json::array();
    for (const CaseResult& result : results) {
      if (result.fault != fault.id) continue;
      ordered_json world = {{"world", result.world}, {"kind", result.kind}};
      world.update(RecordMeasures(result.record));
      ordered_json incidents = robustness::TallyToJson(result.record.tally)["incidents"];
      if (incidents.size() > static_cast<std::size_t>(kMaxIncidents)) {
        incidents.erase(incidents.begin() + kMaxIncidents, incidents.end());
      }
      world["incidents"] = std::move(incidents);
      json["worlds"].push_back(std::move(world));
    }
    faults.push_back(std::move(json));
  }
  return {{"faults", std::move(faults)}};
}

}  // namespace dcloc::faults
