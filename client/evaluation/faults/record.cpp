#include "client/evaluation/faults/record.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dcloc::faults {
namespace {

template <typename T>
void Append(const std::vector<T>& more, std::vector<T>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

std::vector<double> Rounded(std::vector<double> values) {
  for (double& value : values) value = std::round(value * 1e4) * 1e-4;
  return values;
}

std::vector<double> Numbers(const nlohmann::json& json, const char* name) {
  return json.at(name).get<std::vector<double>>();
}

}  // namespace

void Merge(const Record& other, Record& record) {
  record.cases += other.cases;
  record.arrived += other.arrived;
  robustness::Merge(other.tally, record.tally);
  record.meanwhile_scans += other.meanwhile_scans;
  record.meanwhile_tracking += other.meanwhile_tracking;
  Append(other.errors_m, record.errors_m);
  Append(other.meanwhile_errors_m, record.meanwhile_errors_m);
  record.longest_call_ms = std::max(record.longest_call_ms, other.longest_call_ms);
  Append(other.failures, record.failures);
  Merge(other.stanford, record.stanford);
}

nlohmann::ordered_json RecordToJson(const Record& record) {
  return {{"cases", record.cases},
          {"arrived", record.arrived},
          {"tally", robustness::TallyToJson(record.tally)},
          {"meanwhile_scans", record.meanwhile_scans},
          {"meanwhile_tracking", record.meanwhile_tracking},
          {"errors_m", Rounded(record.errors_m)},
          {"meanwhile_errors_m", Rounded(record.meanwhile_errors_m)},
          {"longest_call_ms", record.longest_call_ms},
          {"failures", record.failures},
          {"stanford", StanfordToJson(record.stanford)}};
}

std::optional<Record> RecordFromJson(const nlohmann::json& json) {
  // The library throws at what has another type; here and nowhere further.
  try {
    auto tally = robustness::TallyFromJson(json.at("tally"));
    if (!tally) return std::nullopt;
    Record record;
    record.tally = *std::move(tally);
    record.cases = json.at("cases").get<std::size_t>();
    record.arrived = json.at("arrived").get<std::size_t>();
    record.meanwhile_scans = json.at("meanwhile_scans").get<std::size_t>();
    record.meanwhile_tracking = json.at("meanwhile_tracking").get<std::size_t>();
    record.errors_m = Numbers(json, "errors_m");
    record.meanwhile_errors_m = Numbers(json, "meanwhile_errors_m");
    record.longest_call_ms = json.at("longest_call_ms").get<double>();
    record.failures = json.at("failures").get<std::vector<std::string>>();
    record.stanford = StanfordFromJson(json.at("stanford"));
    return record;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace dcloc::faults
