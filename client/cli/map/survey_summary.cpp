#include "client/cli/map/survey_summary.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/calibration_report.h"
#include "client/cli/common/terminal.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

constexpr double kMinStaticShare = 0.3;

std::size_t AcceptedCount(const Survey& survey) {
  return static_cast<std::size_t>(std::ranges::count(survey.loops, true, &SurveyLoop::is_accepted));
}

double StaticShare(const RadarTally& radar) {
  return radar.target_count == 0
             ? 0.0
             : static_cast<double>(radar.static_count) / static_cast<double>(radar.target_count);
}

ordered_json DriveJson(const DriveTrack& track, const SurveyedDrive& drive) {
  ordered_json radars = ordered_json::array();
  for (const RadarTally& radar : track.radars) {
    radars.push_back({{"radar", radar.radar_id},
                      {"scan_count", radar.scan_count},
                      {"static_share", StaticShare(radar)}});
  }
  return {{"drive", drive.name},
          {"is_in_map", drive.is_in_map},
          {"reason", drive.reason},
          {"way_m", track.arc_length_m},
          {"node_count", track.nodes.size()},
          {"neighbour_count", drive.neighbour_count},
          {"radars", std::move(radars)}};
}

ordered_json JudgementJson(const SurveyJudgement& judgement) {
  return {{"rmse_m", judgement.trajectory.rmse_m},
          {"max_m", judgement.trajectory.max_m},
          {"rmse_deg", judgement.trajectory.rmse_deg},
          {"drift_percent", judgement.drift.translation_percent},
          {"drift_deg_per_100m", judgement.drift.rotation_deg_per_100m},
          {"worst_rmse_before_loops_m", judgement.before_loops.rmse_m},
          {"loop_count", judgement.loop_count},
          {"wrong_loop_count", judgement.wrong_loop_count},
          {"wrong_refused_count", judgement.wrong_refused_count}};
}

std::string JudgementText(const SurveyJudgement& judgement) {
  return absl::StrFormat(
      "against the reference poses, aligned\n"
      "  trajectory       %.3f m RMSE, %.3f m at most, %.3f deg RMSE\n"
      "  before loops     %.3f m RMSE of the worst drive; drift %.3f %%, %.3f deg/100 m\n"
      "  loops            %d accepted, %d of them wrong; %d wrong ones left out\n",
      judgement.trajectory.rmse_m, judgement.trajectory.max_m, judgement.trajectory.rmse_deg,
      judgement.before_loops.rmse_m, judgement.drift.translation_percent,
      judgement.drift.rotation_deg_per_100m, judgement.loop_count, judgement.wrong_loop_count,
      judgement.wrong_refused_count);
}

// Radars whose targets mostly do not fit the ego-motion: something of their description is wrong.
std::string RadarWarnings(const DriveTrack& track) {
  std::string text;
  for (const RadarTally& radar : track.radars) {
    if (radar.target_count == 0 || StaticShare(radar) >= kMinStaticShare) continue;
    absl::StrAppendFormat(&text,
                          "%s: only %.0f %% of what %s sees fits the ego-motion; is its mount as "
                          "the rig says?\n",
                          Visible(track.name), 100.0 * StaticShare(radar), Visible(radar.radar_id));
  }
  return text;
}

}  // namespace

ordered_json SurveyJson(const SurveyBuilder& builder,
                        const std::optional<SurveyJudgement>& judgement) {
  const std::vector<DriveTrack>& tracks = builder.tracks();
  const Survey& survey = builder.survey();
  ordered_json json = {{"drives", ordered_json::array()}};
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    json["drives"].push_back(DriveJson(tracks[i], survey.drives[i]));
  }
  const std::size_t accepted = AcceptedCount(survey);
  json["loops"] = {{"accepted_count", accepted},
                   {"refused_count", survey.loops.size() - accepted},
                   {"unconfirmed_count", survey.unconfirmed_loop_count}};
  json["fixes"] = {{"count", survey.fix_count}, {"accepted_count", survey.accepted_fix_count}};
  if (const auto& scale = builder.scale_correction()) {
    json["scale"] = {{"correction", scale->value}, {"sigma", std::sqrt(scale->variance)}};
  }
  json["radars"] = RadarCalibrationsJson(builder.calibrations());
  if (judgement) json["truth"] = JudgementJson(*judgement);
  return json;
}

std::string SurveyText(const SurveyBuilder& builder,
                       const std::optional<SurveyJudgement>& judgement) {
  const std::vector<DriveTrack>& tracks = builder.tracks();
  const Survey& survey = builder.survey();
  std::vector<std::vector<std::string>> rows = {
      {"drive", "way [m]", "nodes", "landmarks", "neighbours", "in the map"}};
  std::string warnings;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const SurveyedDrive& drive = survey.drives[i];
    std::size_t landmark_count = 0;
    for (const SurveyNode& node : tracks[i].nodes) landmark_count += node.landmarks.size();
    rows.push_back({drive.name, absl::StrFormat("%.0f", tracks[i].arc_length_m),
                    absl::StrCat(tracks[i].nodes.size()), absl::StrCat(landmark_count),
                    absl::StrCat(drive.neighbour_count), drive.is_in_map ? "yes" : "no"});
    if (!drive.reason.empty()) {
      absl::StrAppend(&warnings, Visible(drive.name), ": ", Visible(drive.reason), "\n");
    }
    absl::StrAppend(&warnings, RadarWarnings(tracks[i]));
  }
  const std::size_t accepted = AcceptedCount(survey);
  std::string text = absl::StrCat(FormatTable(rows), warnings, "loops        ", accepted,
                                  " accepted, ", survey.loops.size() - accepted, " left out, ",
                                  survey.unconfirmed_loop_count, " unconfirmed\n");
  if (survey.fix_count > 0) {
    absl::StrAppend(&text, "fixes        ", survey.accepted_fix_count, " of ", survey.fix_count,
                    " agree with the drives\n");
  }
  if (const auto& scale = builder.scale_correction()) {
    absl::StrAppendFormat(&text,
                          "scale        corrected by %+.2f per mil, by slant ranges; known to +- "
                          "%.2f per mil (95 %%)\n",
                          1e3 * scale->value, 1.96e3 * std::sqrt(scale->variance));
  }
  if (!builder.calibrations().empty()) {
    absl::StrAppend(&text,
                    "radars       against their description, with 95 % intervals; * is taken\n",
                    FormatTable(RadarCalibrationRows(builder.calibrations())));
  }
  if (judgement) absl::StrAppend(&text, JudgementText(*judgement));
  return text;
}

Trajectory TrajectoryOf(const DriveTrack& track, const SurveyedDrive& drive) {
  Trajectory trajectory{.name = drive.name, .anchor = std::nullopt, .poses = {}};
  trajectory.poses.reserve(track.scans.size());
  for (const TrackedScan& scan : track.scans) {
    trajectory.poses.push_back({scan.stamp, Embed(PlaceScan(track, drive.T_map_nodes, scan))});
  }
  return trajectory;
}

}  // namespace dcloc::cli
