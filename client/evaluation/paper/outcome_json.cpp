#include "client/evaluation/paper/outcome_json.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace dcloc::paper {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kFields = 11;

// JSON has no infinity, which is what the NEES of a singular covariance is.
Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
double ToNumber(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

Json PoseToJson(const Pose3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  const Eigen::Vector3d& t = pose.translation_m;
  return {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()};
}

Pose3 PoseFromJson(const Json& value) {
  const auto n = value.get<std::array<double, 7>>();
  return {.translation_m = {n[0], n[1], n[2]}, .rotation = {n[3], n[4], n[5], n[6]}};
}

Json ScanToJson(const ScanOutcome& scan) {
  Json stages = Json::array();
  for (const auto& stage_ms : scan.stage_ms) stages.push_back(stage_ms ? Json(*stage_ms) : Json());
  return {scan.answer.stamp.time_since_epoch().count(),
          scan.radar_id,
          static_cast<int>(scan.answer.state),
          PoseToJson(scan.answer.T_map_vehicle),
          PoseToJson(scan.T_map_vehicle_true),
          scan.error.translation_m,
          scan.error.rotation_deg,
          Json{scan.error.dof, Number(scan.error.nees)},
          stages,
          scan.total_ms,
          scan.speed_difference_mps ? Json(*scan.speed_difference_mps) : Json()};
}

ScanOutcome ScanFromJson(const Json& fields) {
  ScanOutcome scan;
  scan.answer.stamp = Stamp(std::chrono::nanoseconds(fields.at(0).get<std::int64_t>()));
  scan.radar_id = fields.at(1).get<std::string>();
  scan.answer.state = static_cast<LocalizationState>(fields.at(2).get<int>());
  scan.answer.T_map_vehicle = PoseFromJson(fields.at(3));
  scan.T_map_vehicle_true = PoseFromJson(fields.at(4));
  scan.error.translation_m = fields.at(5).get<double>();
  scan.error.rotation_deg = fields.at(6).get<double>();
  scan.error.dof = fields.at(7).at(0).get<int>();
  scan.error.nees = ToNumber(fields.at(7).at(1));
  for (std::size_t i = 0; i < scan.stage_ms.size(); ++i) {
    const Json& stage_ms = fields.at(8).at(i);
    if (!stage_ms.is_null()) scan.stage_ms[i] = stage_ms.get<double>();
  }
  scan.total_ms = fields.at(9).get<double>();
  if (!fields.at(10).is_null()) scan.speed_difference_mps = fields.at(10).get<double>();
  return scan;
}

bool IsSound(const Json& fields) {
  return fields.is_array() && fields.size() == kFields && fields[2].is_number_integer() &&
         fields[2].get<int>() >= 0 && fields[2].get<int>() <= 3 && fields[7].is_array() &&
         fields[7].size() == 2 && fields[7][0].is_number_integer() &&
         fields[7][0].get<int>() >= 0 && fields[7][0].get<int>() <= 6;
}

}  // namespace

Json OutcomeToJson(const DriveOutcome& outcome) {
  Json scans = Json::array();
  for (const ScanOutcome& scan : outcome.scans) scans.push_back(ScanToJson(scan));
  return {{"drive", outcome.drive},
          {"refused", outcome.refused_count},
          {"first_refusal", outcome.first_refusal},
          {"scans", std::move(scans)}};
}

std::optional<DriveOutcome> OutcomeFromJson(const Json& value) {
  // The library throws at what has another type; here and nowhere further.
  try {
    DriveOutcome outcome{.drive = value.at("drive").get<std::string>()};
    outcome.refused_count = value.at("refused").get<std::size_t>();
    outcome.first_refusal = value.at("first_refusal").get<std::string>();
    for (const Json& fields : value.at("scans")) {
      if (!IsSound(fields)) return std::nullopt;
      outcome.scans.push_back(ScanFromJson(fields));
    }
    return outcome;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace dcloc::paper
