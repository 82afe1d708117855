#include "client/evaluation/metrics_format.h"

#include <cmath>
#include <functional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

using nlohmann::ordered_json;

ordered_json Number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json Json(const ErrorSummary& summary) {
  return {{"mean", Number(summary.mean)},
          {"median", Number(summary.median)},
          {"rms", Number(summary.rms)},
          {"p95", Number(summary.p95)},
          {"max", Number(summary.max)}};
}

ordered_json Json(const DurationSummary& summary) {
  return {
      {"mean", Number(summary.mean)}, {"p50", Number(summary.p50)}, {"p99", Number(summary.p99)}};
}

std::string Fixed(double value, int digits) {
  if (std::isnan(value)) return "-";
  return absl::StrFormat("%.*f", digits, value);
}

std::string Percent(double share) { return Fixed(100.0 * share, 1); }

std::string FiveNumbers(const ErrorSummary& e, int digits) {
  return absl::StrCat(Fixed(e.mean, digits), " / ", Fixed(e.median, digits), " / ",
                      Fixed(e.rms, digits), " / ", Fixed(e.p95, digits), " / ",
                      Fixed(e.max, digits));
}

std::string TwoNumbers(const DurationSummary& d) {
  return absl::StrCat(Fixed(d.p50, 2), " / ", Fixed(d.p99, 2));
}

std::string Planar(const Pose3& pose) {
  return absl::StrFormat("%.4f,%.4f,%.4f,%.5f", pose.translation_m.x(), pose.translation_m.y(),
                         pose.translation_m.z(), Yaw(pose.rotation) * kDegPerRad);
}

std::string CsvRow(const std::string& drive, const ScanOutcome& scan) {
  const Localization& a = scan.answer;
  const auto sigma = [&](Eigen::Index i) { return std::sqrt(a.covariance(i, i)); };
  return absl::StrFormat(
      "%s,%d,%s,%s,%s,%s,%.4f,%.5f,%.4f,%d,%.5f,%.5f,%.6f,%d,%d,%.4f,%.4f,%.4f,%d,%.4f\n", drive,
      a.stamp.time_since_epoch().count(), scan.radar_id, StateName(a.state),
      Planar(a.T_map_vehicle), Planar(scan.T_map_vehicle_true), scan.error.translation_m,
      scan.error.rotation_deg, scan.error.nees, scan.error.dof, sigma(0), sigma(1),
      sigma(5) * kDegPerRad, a.quality.live_point_count, a.quality.inlier_count, a.quality.overlap,
      a.quality.residual_scale, a.quality.normalized_innovation_squared,
      a.quality.is_accepted ? 1 : 0, scan.total_ms);
}

}  // namespace

const char* StateName(LocalizationState state) {
  switch (state) {
    case LocalizationState::kInitializing:
      return "INITIALIZING";
    case LocalizationState::kTracking:
      return "TRACKING";
    case LocalizationState::kDeadReckoning:
      return "DEAD_RECKONING";
    case LocalizationState::kLost:
      return "LOST";
  }
  return "UNKNOWN";
}

ordered_json MetricsJson(const Metrics& metrics) {
  ordered_json states;
  for (std::size_t i = 0; i < metrics.state_counts.size(); ++i) {
    states[StateName(static_cast<LocalizationState>(i))] = metrics.state_counts[i];
  }
  ordered_json stages;
  for (std::size_t i = 0; i < kStageNames.size(); ++i) {
    stages[kStageNames[i]] = Json(metrics.stage_ms[i]);
  }
  stages["total"] = Json(metrics.total_ms);
  return {{"rte_m", Json(metrics.rte_m)},
          {"rre_deg", Json(metrics.rre_deg)},
          {"success_rate", Number(metrics.success_rate)},
          {"success_rate_all", Number(metrics.success_rate_all)},
          {"anees", Number(metrics.anees)},
          {"coverage_95", Number(metrics.coverage_95)},
          {"coverage_999", Number(metrics.coverage_999)},
          {"misleading_count", metrics.misleading_count},
          {"scans", metrics.scan_count},
          {"answered", metrics.answered_count},
          {"refused", metrics.refused_count},
          {"states", states},
          {"stage_ms", stages}};
}

std::vector<std::vector<std::string>> MetricsRows(
    const std::vector<std::pair<std::string, Metrics>>& columns) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& name,
                       const std::function<std::string(const Metrics&)>& cell) {
    rows.push_back({name});
    for (const auto& [column, metrics] : columns) rows.back().push_back(cell(metrics));
  };
  rows.push_back({""});
  for (const auto& [column, metrics] : columns) rows.back().push_back(column);
  add("RTE mean / median / rms / p95 / max [m]",
      [](const Metrics& m) { return FiveNumbers(m.rte_m, 2); });
  add("RRE mean / median / rms / p95 / max [deg]",
      [](const Metrics& m) { return FiveNumbers(m.rre_deg, 2); });
  add("success (< 2 m, < 5 deg) of answered [%]",
      [](const Metrics& m) { return Percent(m.success_rate); });
  add("success of all scans [%]", [](const Metrics& m) { return Percent(m.success_rate_all); });
  add("ANEES per degree of freedom", [](const Metrics& m) { return Fixed(m.anees, 2); });
  add("truth in 95 % / 99.9 % ellipsoid [%]", [](const Metrics& m) {
    return absl::StrCat(Percent(m.coverage_95), " / ", Percent(m.coverage_999));
  });
  add("misleading answers", [](const Metrics& m) { return absl::StrCat(m.misleading_count); });
  add("scans answered / taken / refused", [](const Metrics& m) {
    return absl::StrCat(m.answered_count, " / ", m.scan_count, " / ", m.refused_count);
  });
  add("tracking / dead reckoning / lost", [](const Metrics& m) {
    return absl::StrCat(m.state_counts[1], " / ", m.state_counts[2], " / ", m.state_counts[3]);
  });
  for (std::size_t i = 0; i < kStageNames.size(); ++i) {
    add(absl::StrCat(kStageNames[i], " p50 / p99 [ms]"),
        [i](const Metrics& m) { return TwoNumbers(m.stage_ms[i]); });
  }
  add("total p50 / p99 [ms]", [](const Metrics& m) { return TwoNumbers(m.total_ms); });
  return rows;
}

std::string ScansCsv(const std::vector<DriveOutcome>& drives) {
  std::string csv =
      "drive,stamp_ns,radar,state,x_m,y_m,z_m,yaw_deg,true_x_m,true_y_m,true_z_m,true_yaw_deg,"
      "rte_m,rre_deg,nees,dof,sigma_x_m,sigma_y_m,sigma_yaw_deg,live_points,inliers,overlap,"
      "residual_scale,edge_distance,edge_valid,total_ms\n";
  for (const DriveOutcome& drive : drives) {
    for (const ScanOutcome& scan : drive.scans) csv += CsvRow(drive.drive, scan);
  }
  return csv;
}

}  // namespace dcloc
