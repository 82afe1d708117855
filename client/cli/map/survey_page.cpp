#include "client/cli/map/survey_page.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/calibration_report.h"
#include "client/evaluation/html.h"
#include "client/evaluation/map_drawing.h"

namespace dcloc::cli {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Pose2 NodeOf(const Survey& survey, std::size_t drive, std::size_t node) {
  return survey.drives[drive].T_map_nodes[node];
}

/// By ego-motion and neighbours alone, from where the survey has the first node.
Pose2 BeforeLoops(const SurveyedDrive& drive, std::size_t node) {
  return drive.T_map_nodes.front() * drive.T_start_nodes.front().Inverse() *
         drive.T_start_nodes[node];
}

/// How far the loops have moved the drive's nodes at most.
double LargestMove_m(const SurveyedDrive& drive) {
  double largest_m = 0.0;
  for (std::size_t i = 0; i < drive.T_start_nodes.size(); ++i) {
    largest_m =
        std::max(largest_m,
                 (drive.T_map_nodes[i].translation_m - BeforeLoops(drive, i).translation_m).norm());
  }
  return largest_m;
}

std::string DrawingOf(const Survey& survey) {
  MapDrawing drawing;
  for (const SurveyedDrive& drive : survey.drives) {
    if (!drive.is_in_map) continue;
    std::vector<Eigen::Vector2d> before, after;
    for (std::size_t i = 0; i < drive.T_map_nodes.size(); ++i) {
      before.push_back(BeforeLoops(drive, i).translation_m);
      after.push_back(drive.T_map_nodes[i].translation_m);
    }
    drawing.Polyline(MapDrawing::Layer::kBelow, before, 1.0, "#bbb");
    drawing.Polyline(MapDrawing::Layer::kAbove, after, 1.0, "#009e73");
  }
  for (const SurveyLoop& loop : survey.loops) {
    if (!survey.drives[loop.drive_from].is_in_map || !survey.drives[loop.drive_to].is_in_map) {
      continue;
    }
    drawing.Line(MapDrawing::Layer::kAbove,
                 NodeOf(survey, loop.drive_from, loop.node_from).translation_m,
                 NodeOf(survey, loop.drive_to, loop.node_to).translation_m, 0.6,
                 loop.is_accepted ? "#0072b2" : "#d55e00");
  }
  return drawing.Svg("drives and loops");
}

Rows DriveRows(std::span<const DriveTrack> tracks, const Survey& survey) {
  Rows rows = {{"drive", "way [m]", "nodes", "neighbours", "moved by loops [m]", "in the map"}};
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const SurveyedDrive& drive = survey.drives[i];
    rows.push_back({drive.name, absl::StrFormat("%.0f", tracks[i].arc_length_m),
                    absl::StrCat(tracks[i].nodes.size()), absl::StrCat(drive.neighbour_count),
                    drive.is_in_map ? absl::StrFormat("%.2f", LargestMove_m(drive)) : "",
                    drive.is_in_map
                        ? absl::StrCat("yes", drive.reason.empty() ? "" : ": ", drive.reason)
                        : absl::StrCat("no: ", drive.reason)});
  }
  return rows;
}

Rows LoopRows(const Survey& survey) {
  Rows rows = {{"from", "to", "off the solution [sigma]", ""}};
  for (const SurveyLoop& loop : survey.loops) {
    const auto place = [&](std::size_t drive, std::size_t node) {
      const Eigen::Vector2d& p_m = NodeOf(survey, drive, node).translation_m;
      return absl::StrFormat("%s (%.0f, %.0f)", survey.drives[drive].name, p_m.x(), p_m.y());
    };
    rows.push_back({place(loop.drive_from, loop.node_from), place(loop.drive_to, loop.node_to),
                    absl::StrFormat("%.1f", std::sqrt(loop.squared_distance)),
                    loop.is_accepted ? "" : "left out"});
  }
  return rows;
}

}  // namespace

std::string SurveyHtml(const SurveyBuilder& builder) {
  const std::vector<DriveTrack>& tracks = builder.tracks();
  const Survey& survey = builder.survey();
  const auto accepted = std::ranges::count(survey.loops, true, &SurveyLoop::is_accepted);
  std::string body = absl::StrFormat(
      "<p>Green: the drives as the survey has placed them. Grey: by ego-motion and neighbours "
      "alone. Blue: %d loops. Red: %d that contradict the others and were left out. %d more were "
      "confirmed by no others.</p>\n",
      accepted, static_cast<std::int64_t>(survey.loops.size()) - accepted,
      survey.unconfirmed_loop_count);
  if (survey.fix_count > 0) {
    absl::StrAppendFormat(&body, "<p>%d of %d position fixes agree with the drives.</p>\n",
                          survey.accepted_fix_count, survey.fix_count);
  }
  if (const auto& scale = builder.scale_correction()) {
    absl::StrAppendFormat(
        &body,
        "<p>By slant ranges the scale was corrected by %+.2f per mil. It is known "
        "to +- %.2f per mil (95 %%).</p>\n",
        1e3 * scale->value, 1.96e3 * std::sqrt(scale->variance));
  }
  absl::StrAppend(&body, DrawingOf(survey), HtmlTable(DriveRows(tracks, survey)));
  if (!builder.calibrations().empty()) {
    absl::StrAppend(&body,
                    "<h2>Radars</h2>\n<p>What the drives tell of errors in their description, with "
                    "95 % intervals. What has a star was taken for the map.</p>\n",
                    HtmlTable(RadarCalibrationRows(builder.calibrations())));
  }
  if (!survey.loops.empty()) {
    absl::StrAppend(&body, "<h2>Loops</h2>\n", HtmlTable(LoopRows(survey)));
  }
  return HtmlPage("Survey", body);
}

}  // namespace dcloc::cli
