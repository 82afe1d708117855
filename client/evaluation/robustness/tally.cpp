#include "client/evaluation/robustness/tally.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace dcloc::robustness {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

// JSON has no infinity, which is what the NEES of a singular covariance is.
ordered_json NumberToJson(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}
double NumberFromJson(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

ordered_json IncidentToJson(const Incident& incident) {
  return {{"what", incident.what},
          {"drive", incident.drive},
          {"at_s", incident.at_s},
          {"error_m", incident.error_m},
          {"error_deg", incident.error_deg},
          {"nees", NumberToJson(incident.nees)},
          {"for_s", NumberToJson(incident.for_s)}};
}

Incident IncidentFromJson(const json& value) {
  return {.what = value.at("what").get<std::string>(),
          .drive = value.at("drive").get<std::string>(),
          .at_s = value.at("at_s").get<double>(),
          .error_m = value.at("error_m").get<double>(),
          .error_deg = value.at("error_deg").get<double>(),
          .nees = NumberFromJson(value.at("nees")),
          .for_s = NumberFromJson(value.at("for_s"))};
}

/// Calls `visit(name, member)` for every count, and so keeps reading and writing in step.
template <typename AnyTally, typename Visit>
void VisitCounts(AnyTally& tally, const Visit& visit) {
  visit("scans", tally.scans);
  visit("right", tally.right);
  visit("flagged", tally.flagged);
  visit("wrong", tally.wrong);
  visit("misleading", tally.misleading);
  visit("tracking", tally.tracking);
  visit("refused", tally.refused);
  visit("nees_count", tally.nees_count);
  visit("inside_95", tally.inside_95);
  visit("disturbed_nees_count", tally.disturbed_nees_count);
  visit("disturbed_inside_95", tally.disturbed_inside_95);
  visit("episodes", tally.episodes);
  visit("starts", tally.starts);
  visit("wrong_claims", tally.wrong_claims);
}

}  // namespace

void Tally::Add(Incident incident) {
  if (incidents.size() < kMaxIncidents) incidents.push_back(std::move(incident));
}

void Merge(const Tally& other, Tally& tally) {
  std::vector<std::size_t> more;
  VisitCounts(other, [&](const char*, std::size_t count) { more.push_back(count); });
  auto next = more.begin();
  VisitCounts(tally, [&](const char*, std::size_t& count) { count += *next++; });
  tally.worst_tracking_m = std::max(tally.worst_tracking_m, other.worst_tracking_m);
  tally.nees_per_dof_sum += other.nees_per_dof_sum;
  tally.disturbed_nees_per_dof_sum += other.disturbed_nees_per_dof_sum;
  tally.recovery_s.insert(tally.recovery_s.end(), other.recovery_s.begin(), other.recovery_s.end());
  tally.right_claim_s.insert(tally.right_claim_s.end(), other.right_claim_s.begin(),
                             other.right_claim_s.end());
  for (const Incident& incident : other.incidents) tally.Add(incident);
}

double QuantileOf(std::vector<double> values, std::size_t count, double quantile) {
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  const double rank = std::ceil(quantile * static_cast<double>(count));
  const auto index = static_cast<std::size_t>(std::max(1.0, rank)) - 1;
  if (index >= values.size()) return std::numeric_limits<double>::infinity();
  std::ranges::sort(values);
  return values[index];
}

double ShareWithin(const std::vector<double>& values, std::size_t count, double limit) {
  if (count == 0) return std::numeric_limits<double>::quiet_NaN();
  const auto within = std::ranges::count_if(values, [&](double value) { return value <= limit; });
  return static_cast<double>(within) / static_cast<double>(count);
}

ordered_json TallyToJson(const Tally& tally) {
  ordered_json json;
  VisitCounts(tally, [&](const char* name, std::size_t count) { json[name] = count; });
  json["worst_tracking_m"] = tally.worst_tracking_m;
  json["nees_per_dof_sum"] = NumberToJson(tally.nees_per_dof_sum);
  json["disturbed_nees_per_dof_sum"] = NumberToJson(tally.disturbed_nees_per_dof_sum);
  json["recovery_s"] = tally.recovery_s;
  json["right_claim_s"] = tally.right_claim_s;
  json["incidents"] = ordered_json::array();
  for (const Incident& incident : tally.incidents) {
    json["incidents"].push_back(IncidentToJson(incident));
  }
  return json;
}

std::optional<Tally> TallyFromJson(const json& value) {
  // The library throws at what has another type; here and nowhere further.
  try {
    Tally tally;
    VisitCounts(tally, [&](const char* name, std::size_t& count) {
      count = value.at(name).get<std::size_t>();
    });
    tally.worst_tracking_m = value.at("worst_tracking_m").get<double>();
    tally.nees_per_dof_sum = NumberFromJson(value.at("nees_per_dof_sum"));
    tally.disturbed_nees_per_dof_sum = NumberFromJson(value.at("disturbed_nees_per_dof_sum"));
    tally.recovery_s = value.at("recovery_s").get<std::vector<double>>();
    tally.right_claim_s = value.at("right_claim_s").get<std::vector<double>>();
    for (const json& incident : value.at("incidents")) tally.Add(IncidentFromJson(incident));
    return tally;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace dcloc::robustness
