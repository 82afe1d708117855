#include "client/cli/map/update_report.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/html.h"
#include "client/evaluation/map_drawing.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

std::string DateOf(const std::optional<Stamp>& stamp) {
  if (!stamp) return "never";
  const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(*stamp)};
  return absl::StrFormat("%04d-%02d-%02d", static_cast<int>(day.year()),
                         static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()));
}

std::optional<Stamp> BeginOf(const PlacedPass& pass) {
  if (pass.scans.empty()) return std::nullopt;
  return pass.scans.front().stamp;
}

/// The pass from which on a landmark was there, or was not.
std::optional<Stamp> SinceOf(const UpdateReport& report, const LandmarkHistory& landmark) {
  const std::vector<std::size_t>& order = report.judged.update.order;
  if (landmark.presence.since >= order.size()) return std::nullopt;
  return BeginOf(report.judged.passes[order[landmark.presence.since]]);
}

std::size_t CountOf(const std::vector<LandmarkHistory>& landmarks, LandmarkFate fate) {
  return static_cast<std::size_t>(std::ranges::count(landmarks, fate, &LandmarkHistory::fate));
}

/// When the middle of a street segment was last driven past.
std::optional<Stamp> LastDriven(const UpdateReport& report, const SegmentEvaluation& segment) {
  constexpr double kNear_m = 60.0;
  std::optional<Stamp> last;
  for (const PlacedPass& pass : report.judged.passes) {
    for (const PlacedScan& scan : pass.scans) {
      if (!scan.is_good || (last && scan.stamp <= *last)) continue;
      const double distance_m =
          (scan.T_map_vehicle.translation_m - segment.p_map_m).head<2>().norm();
      if (distance_m <= kNear_m) last = scan.stamp;
    }
  }
  return last;
}

ordered_json ScoreJson(const VersionScore& score) {
  return {{"error_m", score.error_m},   {"error_p90_m", score.error_p90_m},
          {"offset_m", score.offset_m}, {"tracking_share", score.tracking_share},
          {"nees", score.nees},         {"fit", score.fit}};
}

ordered_json SegmentJson(const UpdateReport& report, const SegmentEvaluation& segment) {
  return {{"x_m", segment.p_map_m.x()},
          {"y_m", segment.p_map_m.y()},
          {"last_driven", DateOf(LastDriven(report, segment))},
          {"scan_count", segment.scan_count},
          {"agreed_count", segment.agreed_count},
          {"went_count", segment.removed_count},
          {"came_count", segment.added_count},
          {"agreed_seen", segment.agreed_seen},
          {"went_seen", segment.removed_seen},
          {"came_seen", segment.added_seen},
          {"old", ScoreJson(segment.old_version)},
          {"new", ScoreJson(segment.new_version)},
          {"fault", segment.fault}};
}

ordered_json LandmarksJson(const UpdateReport& report, LandmarkFate fate) {
  ordered_json list = ordered_json::array();
  for (const auto* landmarks : {&report.judged.update.known, &report.judged.update.found}) {
    for (const LandmarkHistory& landmark : *landmarks) {
      if (landmark.fate != fate) continue;
      list.push_back({{"x_m", landmark.p_map_m.x()},
                      {"y_m", landmark.p_map_m.y()},
                      {"since", DateOf(SinceOf(report, landmark))},
                      {"first_seen", DateOf(landmark.first_seen)},
                      {"last_seen", DateOf(landmark.last_seen)},
                      {"witness_count", landmark.witness_count},
                      {"vehicle_count", landmark.vehicle_count}});
    }
  }
  return list;
}

ordered_json PassesJson(const UpdateReport& report) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < report.judged.passes.size(); ++i) {
    const PlacedPass& pass = report.judged.passes[i];
    list.push_back({{"name", pass.name},
                    {"date", DateOf(BeginOf(pass))},
                    {"scan_count", pass.scans.size()},
                    {"good_count", pass.GoodCount()},
                    {"beyond_count", pass.BeyondCount()},
                    {"untracked_count", pass.untracked_count},
                    {"unsure_count", pass.unsure_count},
                    {"unsound_count", pass.unsound_count},
                    {"refused_count", pass.refused_count},
                    {"length_m", pass.length_m},
                    {"fault", report.judged.faults[i]}});
  }
  return list;
}

std::vector<std::string> ScoreRow(const std::string& name, const VersionScore& score) {
  return {name,
          absl::StrFormat("%.3f", score.error_m),
          absl::StrFormat("%.3f", score.error_p90_m),
          absl::StrFormat("%.3f", score.offset_m),
          absl::StrFormat("%.1f %%", 100.0 * score.tracking_share),
          absl::StrFormat("%.2f", score.nees),
          absl::StrFormat("%.4f", score.fit)};
}

std::vector<std::vector<std::string>> SegmentRows(const UpdateReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"street segment at (x, y) m", "last driven", "scans", "stay", "went", "came",
       "error before, after [m]", "fit before, after", "verdict"}};
  for (const SegmentEvaluation& segment : report.judged.gate.segments) {
    rows.push_back(
        {absl::StrFormat("%.0f, %.0f", segment.p_map_m.x(), segment.p_map_m.y()),
         DateOf(LastDriven(report, segment)), absl::StrCat(segment.scan_count),
         absl::StrCat(segment.agreed_count), absl::StrCat(segment.removed_count),
         absl::StrCat(segment.added_count),
         absl::StrFormat("%.3f, %.3f", segment.old_version.error_m, segment.new_version.error_m),
         absl::StrFormat("%.3f, %.3f", segment.old_version.fit, segment.new_version.fit),
         segment.scan_count == 0 ? "not driven"
         : segment.fault.empty() ? "good"
                                 : segment.fault});
  }
  return rows;
}

std::vector<std::vector<std::string>> PassRows(const UpdateReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"drive", "date", "scans", "that count", "beyond the map", "verdict"}};
  for (std::size_t i = 0; i < report.judged.passes.size(); ++i) {
    const PlacedPass& pass = report.judged.passes[i];
    rows.push_back({pass.name, DateOf(BeginOf(pass)), absl::StrCat(pass.scans.size()),
                    absl::StrCat(pass.GoodCount()), absl::StrCat(pass.BeyondCount()),
                    report.judged.faults[i].empty() ? "of use" : report.judged.faults[i]});
  }
  return rows;
}

/// The changed landmarks over what stays.
std::string DrawingOf(const MapUpdate& update) {
  MapDrawing drawing;
  for (const auto* landmarks : {&update.known, &update.found}) {
    for (const LandmarkHistory& landmark : *landmarks) {
      const Eigen::Vector2d p_map_m = landmark.p_map_m.head<2>();
      const auto mark = [&](const char* colour) {
        drawing.Circle(MapDrawing::Layer::kAbove, p_map_m, 0.8, colour);
      };
      switch (landmark.fate) {
        case LandmarkFate::kKept:
          drawing.Circle(MapDrawing::Layer::kBelow, p_map_m, 0.4, "#bbb");
          break;
        case LandmarkFate::kAdded:
          mark("#009e73");
          break;
        case LandmarkFate::kRemoved:
          mark("#d55e00");
          break;
        case LandmarkFate::kIntermittent:
          mark("#56b4e9");
          break;
        case LandmarkFate::kUnproven:
          break;
      }
    }
  }
  return drawing.Svg("changes");
}

std::string NewStreetsText(const NewStreets& streets) {
  if (streets.joined_m + streets.unproven_m == 0.0) return "none";
  return absl::StrFormat("%.0f m joined, %.0f m driven by too few vehicles or days",
                         streets.joined_m, streets.unproven_m);
}

std::string OnlyNewStreetsText(const JudgedUpdate& judged) {
  return judged.has_only_new_streets ? "; the rest was worse, and stays as it was" : "";
}

std::size_t ComesAndGoesCount(const MapUpdate& update) {
  return CountOf(update.known, LandmarkFate::kIntermittent) +
         CountOf(update.found, LandmarkFate::kIntermittent);
}

}  // namespace

ordered_json UpdateJson(const UpdateReport& report) {
  ordered_json segments = ordered_json::array();
  for (const SegmentEvaluation& segment : report.judged.gate.segments) {
    segments.push_back(SegmentJson(report, segment));
  }
  const MapUpdate& update = report.judged.update;
  return {
      {"base", report.base},
      {"out", report.out},
      {"passes", PassesJson(report)},
      {"kept_count", CountOf(update.known, LandmarkFate::kKept)},
      {"refined_count", update.refined_count},
      {"new_streets",
       {{"joined_m", update.new_streets.joined_m}, {"unproven_m", update.new_streets.unproven_m}}},
      {"came", LandmarksJson(report, LandmarkFate::kAdded)},
      {"went", LandmarksJson(report, LandmarkFate::kRemoved)},
      {"comes_and_goes", LandmarksJson(report, LandmarkFate::kIntermittent)},
      {"gate",
       {{"kept_out", report.judged.held_out},
        {"is_better", report.judged.gate.is_better},
        {"reason", report.judged.gate.reason},
        {"old", ScoreJson(report.judged.gate.whole.old_version)},
        {"new", ScoreJson(report.judged.gate.whole.new_version)},
        {"has_only_new_streets", report.judged.has_only_new_streets},
        {"segments", segments}}}};
}

std::string UpdateText(const UpdateReport& report) {
  const MapUpdate& update = report.judged.update;
  std::string text;
  for (std::size_t i = 0; i < report.judged.passes.size(); ++i) {
    const PlacedPass& pass = report.judged.passes[i];
    absl::StrAppendFormat(
        &text, "%-14s %d of %d scans count%s%s\n", pass.name, pass.GoodCount(), pass.scans.size(),
        report.judged.faults[i].empty() ? "" : "; left out: ", report.judged.faults[i]);
  }
  absl::StrAppendFormat(
      &text,
      "kept           %d, %d of them refined\ncame           %d\nwent           %d\n"
      "comes and goes %d\nnew streets    %s%s\n",
      CountOf(update.known, LandmarkFate::kKept), update.refined_count,
      CountOf(update.found, LandmarkFate::kAdded), CountOf(update.known, LandmarkFate::kRemoved),
      ComesAndGoesCount(update), NewStreetsText(update.new_streets),
      OnlyNewStreetsText(report.judged));
  const SegmentEvaluation& whole = report.judged.gate.whole;
  absl::StrAppendFormat(
      &text,
      "%-14s median error %.3f m, before %.3f m; fit %.4f, before %.4f; tracks %.1f %%, before "
      "%.1f %%\n%s: %s\n",
      report.judged.held_out, whole.new_version.error_m, whole.old_version.error_m,
      whole.new_version.fit, whole.old_version.fit, 100.0 * whole.new_version.tracking_share,
      100.0 * whole.old_version.tracking_share, report.out.empty() ? "not written" : report.out,
      report.judged.gate.reason);
  return text;
}

std::string UpdateHtml(const UpdateReport& report) {
  const MapUpdate& update = report.judged.update;
  std::string body = absl::StrFormat(
      "<p>%s. Green came (%d), red went (%d), blue comes and goes (%d), grey stays (%d). New "
      "streets: %s%s.</p>\n",
      EscapeHtml(report.out.empty()
                     ? absl::StrCat("Not written: ", report.judged.gate.reason)
                     : absl::StrCat("Written to ", report.out, ": ", report.judged.gate.reason)),
      CountOf(update.found, LandmarkFate::kAdded), CountOf(update.known, LandmarkFate::kRemoved),
      ComesAndGoesCount(update), CountOf(update.known, LandmarkFate::kKept),
      NewStreetsText(update.new_streets), OnlyNewStreetsText(report.judged));
  absl::StrAppend(
      &body, DrawingOf(update), "<h2>Drives</h2>\n", HtmlTable(PassRows(report)),
      "<h2>The drive that was kept out: ", EscapeHtml(report.judged.held_out), "</h2>\n",
      HtmlTable({{"version", "median error [m]", "90 % [m]", "offset [m]", "tracks", "NEES", "fit"},
                 ScoreRow("old", report.judged.gate.whole.old_version),
                 ScoreRow("new", report.judged.gate.whole.new_version)}),
      "<h2>Street segments</h2>\n", HtmlTable(SegmentRows(report)));
  std::vector<std::vector<std::string>> rows = {
      {"change", "x [m]", "y [m]", "since", "last seen", "days or vehicles"}};
  for (const auto* landmarks : {&update.known, &update.found}) {
    for (const LandmarkHistory& landmark : *landmarks) {
      if (landmark.fate != LandmarkFate::kAdded && landmark.fate != LandmarkFate::kRemoved) {
        continue;
      }
      rows.push_back({kLandmarkFateNames[static_cast<std::size_t>(landmark.fate)],
                      absl::StrFormat("%.1f", landmark.p_map_m.x()),
                      absl::StrFormat("%.1f", landmark.p_map_m.y()),
                      DateOf(SinceOf(report, landmark)), DateOf(landmark.last_seen),
                      absl::StrCat(landmark.witness_count)});
    }
  }
  absl::StrAppend(&body, "<h2>Changes</h2>\n", HtmlTable(rows));
  return HtmlPage(absl::StrCat("Update of ", report.base), body);
}

}  // namespace dcloc::cli
