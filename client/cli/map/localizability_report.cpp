#include "client/cli/map/localizability_report.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/string_view.h"
#include "client/cli/map/map_report.h"
#include "client/evaluation/html.h"
#include "client/evaluation/map_drawing.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

constexpr double kDegPerRad = 180.0 / 3.14159265358979323846;
constexpr double kGood_m = 0.1;  // a lane keeps its middle
constexpr double kFair_m = 0.3;  // a vehicle keeps its lane

Eigen::Vector3d PositionOf(const LocalizabilityReport& report, std::size_t keyframe) {
  return report.map->keyframe(keyframe).T_map_keyframe.translation_m;
}

/// The least of which half the landmarks have as many, or more.
int PassCountOf(const Keyframe& keyframe) {
  std::vector<int> counts;
  for (const MapPoint& point : keyframe.points) counts.push_back(point.pass_count);
  if (counts.empty()) return 0;
  const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2);
  std::ranges::nth_element(counts, middle);
  return *middle;
}

double LargestSigma(const KeyframeLocalizability& keyframe) {
  return std::max(keyframe.along_sigma_m, keyframe.across_sigma_m);
}

/// Values over the keyframes of which they are known.
struct Spread {
  double median = 0.0, share_90 = 0.0, worst = 0.0;

  Spread(const LocalizabilityReport& report,
         const std::function<double(const KeyframeLocalizability&)>& value) {
    std::vector<double> values;
    for (const KeyframeLocalizability& keyframe : report.keyframes) {
      if (keyframe.is_known) values.push_back(value(keyframe));
    }
    if (values.empty()) return;
    std::ranges::sort(values);
    median = values[values.size() / 2];
    share_90 = values[values.size() * 9 / 10];
    worst = values.back();
  }
};

struct Summary {
  explicit Summary(const LocalizabilityReport& report)
      : along_m(report, [](const auto& keyframe) { return keyframe.along_sigma_m; }),
        across_m(report, [](const auto& keyframe) { return keyframe.across_sigma_m; }),
        heading_deg(report,
                    [](const auto& keyframe) { return keyframe.heading_sigma_rad * kDegPerRad; }) {
    for (const KeyframeLocalizability& keyframe : report.keyframes) {
      if (!keyframe.is_known) ++unknown_count;
      if (keyframe.is_tunnel) ++tunnel_count;
      if (keyframe.alias) ++alias_count;
    }
  }

  Spread along_m, across_m, heading_deg;
  int unknown_count = 0;
  int tunnel_count = 0;
  int alias_count = 0;
};

ordered_json SpreadJson(const Spread& spread) {
  return {{"median", spread.median}, {"p90", spread.share_90}, {"worst", spread.worst}};
}

ordered_json KeyframeJson(const LocalizabilityReport& report, std::size_t index) {
  const KeyframeLocalizability& keyframe = report.keyframes[index];
  const Eigen::Vector3d p_map_m = PositionOf(report, index);
  ordered_json json = {{"x_m", p_map_m.x()},
                       {"y_m", p_map_m.y()},
                       {"passes", PassCountOf(report.map->keyframe(index))},
                       {"along_sigma_m", nullptr},
                       {"across_sigma_m", nullptr},
                       {"heading_sigma_deg", nullptr},
                       {"tracking_share", nullptr},
                       {"is_tunnel", keyframe.is_tunnel},
                       {"alias", nullptr}};
  if (keyframe.is_known) {
    json["along_sigma_m"] = keyframe.along_sigma_m;
    json["across_sigma_m"] = keyframe.across_sigma_m;
    json["heading_sigma_deg"] = keyframe.heading_sigma_rad * kDegPerRad;
    json["tracking_share"] = keyframe.tracking_share;
  }
  if (keyframe.alias) {
    const Pose3& other = keyframe.alias->T_map_vehicle;
    json["alias"] = {{"x_m", other.translation_m.x()},
                     {"y_m", other.translation_m.y()},
                     {"yaw_deg", Yaw(other.rotation) * kDegPerRad},
                     {"lead", keyframe.alias->lead}};
  }
  return json;
}

/// Keyframes of one kind that follow one another: [begin, end).
struct Run {
  std::size_t begin = 0, end = 0;
};

std::vector<Run> RunsOf(const LocalizabilityReport& report,
                        const std::function<bool(const KeyframeLocalizability&)>& is_kind) {
  std::vector<Run> runs;
  for (std::size_t i = 0; i < report.keyframes.size(); ++i) {
    if (!is_kind(report.keyframes[i])) continue;
    if (!runs.empty() && runs.back().end == i) {
      ++runs.back().end;
    } else {
      runs.push_back({i, i + 1});
    }
  }
  return runs;
}

std::string PlaceText(const Eigen::Vector3d& p_map_m) {
  return absl::StrFormat("(%.0f, %.0f)", p_map_m.x(), p_map_m.y());
}

using Rows = std::vector<std::vector<std::string>>;

Rows TunnelRows(const LocalizabilityReport& report) {
  Rows rows = {{"from [m]", "to [m]", "keyframes", "largest deviation along [m]"}};
  for (const Run& run : RunsOf(report, [](const auto& k) { return k.is_tunnel; })) {
    double worst_m = 0.0;
    for (std::size_t i = run.begin; i < run.end; ++i) {
      worst_m = std::max(worst_m, report.keyframes[i].along_sigma_m);
    }
    rows.push_back({PlaceText(PositionOf(report, run.begin)),
                    PlaceText(PositionOf(report, run.end - 1)), absl::StrCat(run.end - run.begin),
                    absl::StrFormat("%.2f", worst_m)});
  }
  return rows;
}

Rows AliasRows(const LocalizabilityReport& report) {
  Rows rows = {{"place [m]", "looks like [m]", "distance [m]", "lead of the right one"}};
  for (std::size_t i = 0; i < report.keyframes.size(); ++i) {
    const std::optional<Alias>& alias = report.keyframes[i].alias;
    if (!alias) continue;
    const Eigen::Vector3d p_map_m = PositionOf(report, i);
    const Eigen::Vector3d& other_m = alias->T_map_vehicle.translation_m;
    rows.push_back({PlaceText(p_map_m), PlaceText(other_m),
                    absl::StrFormat("%.0f", (p_map_m - other_m).head<2>().norm()),
                    absl::StrFormat("%.1f", alias->lead)});
  }
  return rows;
}

Rows SigmaRows(const Summary& summary) {
  const auto row = [](const char* name, const Spread& spread, const char* format) {
    const auto text = [&](double value) {
      return absl::StrFormat(*absl::ParsedFormat<'f'>::New(format), value);
    };
    return std::vector<std::string>{name, text(spread.median), text(spread.share_90),
                                    text(spread.worst)};
  };
  return {{"expected deviation", "median", "90 %", "worst"},
          row("along [m]", summary.along_m, "%.3f"),
          row("across [m]", summary.across_m, "%.3f"),
          row("heading [deg]", summary.heading_deg, "%.3f")};
}

const char* ColourOf(const KeyframeLocalizability& keyframe) {
  if (!keyframe.is_known) return "#fff";
  if (LargestSigma(keyframe) <= kGood_m) return "#009e73";
  return LargestSigma(keyframe) <= kFair_m ? "#e69f00" : "#d55e00";
}

/// The way by what a vehicle can expect, over the landmarks.
std::string DrawingOf(const LocalizabilityReport& report) {
  constexpr std::size_t kMaxDrawn = 20'000;  // landmarks; of more, each second, third ...
  const std::size_t stride = report.map->info().point_count / kMaxDrawn + 1;
  MapDrawing drawing;
  std::size_t number = 0;
  for (std::size_t i = 0; i < report.keyframes.size(); ++i) {
    const Keyframe keyframe = report.map->keyframe(i);
    for (const MapPoint& point : keyframe.points) {
      if (number++ % stride != 0) continue;
      const Eigen::Vector3d p_map_m =
          keyframe.T_map_keyframe * Eigen::Vector3d(point.x_m, point.y_m, 0.0);
      drawing.Circle(MapDrawing::Layer::kBelow, p_map_m.head<2>(), 0.4, "#bbb");
    }
  }
  for (std::size_t i = 0; i < report.keyframes.size(); ++i) {
    const KeyframeLocalizability& keyframe = report.keyframes[i];
    const Eigen::Vector2d p_map_m = PositionOf(report, i).head<2>();
    if (keyframe.alias) {
      drawing.Line(MapDrawing::Layer::kBelow, p_map_m,
                   keyframe.alias->T_map_vehicle.translation_m.head<2>(), 0.5, "#0072b2", 2.0);
    }
    const char* const rim = keyframe.is_tunnel ? "#000" : keyframe.alias ? "#0072b2" : "none";
    drawing.Circle(MapDrawing::Layer::kAbove, p_map_m, 3.0, ColourOf(keyframe), rim);
  }
  return drawing.Svg("localizability along the way");
}

}  // namespace

ordered_json LocalizabilityJson(const LocalizabilityReport& report) {
  const Summary summary(report);
  ordered_json keyframes = ordered_json::array();
  for (std::size_t i = 0; i < report.keyframes.size(); ++i) {
    keyframes.push_back(KeyframeJson(report, i));
  }
  return {{"file", report.file},
          {"map", MapInfoJson(report.map->info())},
          {"along_sigma_m", SpreadJson(summary.along_m)},
          {"across_sigma_m", SpreadJson(summary.across_m)},
          {"heading_sigma_deg", SpreadJson(summary.heading_deg)},
          {"unknown_count", summary.unknown_count},
          {"tunnel_count", summary.tunnel_count},
          {"alias_count", summary.alias_count},
          {"keyframes", keyframes}};
}

std::string LocalizabilityText(const LocalizabilityReport& report) {
  const Summary summary(report);
  const auto line = [](const char* name, const Spread& spread, const char* unit) {
    return absl::StrFormat("%-12s %.3f %s in the median, %.3f in 90 %%, %.3f at worst\n", name,
                           spread.median, unit, spread.share_90, spread.worst);
  };
  return absl::StrCat(
      MapInfoText(report.map->info()), line("along", summary.along_m, "m"),
      line("across", summary.across_m, "m"), line("heading", summary.heading_deg, "deg"),
      absl::StrFormat("places       %d: %d tunnels to the radar, %d look like others, %d not "
                      "reached\n",
                      report.keyframes.size(), summary.tunnel_count, summary.alias_count,
                      summary.unknown_count));
}

std::string LocalizabilityHtml(const LocalizabilityReport& report) {
  const Summary summary(report);
  std::string body = absl::StrFormat(
      "<p>What a vehicle can expect that comes along the mapped way. Green: known to %.1f m in "
      "each "
      "direction. Yellow: to %.1f m. Red: worse. White: not reached.</p>\n"
      "<p>Black rings are tunnels to the radar. Blue rings look like the place at the other end of "
      "the broken line to a vehicle that does not know where it is.</p>\n",
      kGood_m, kFair_m);
  absl::StrAppend(&body, DrawingOf(report), "<pre>", EscapeHtml(MapInfoText(report.map->info())),
                  "</pre>\n", HtmlTable(SigmaRows(summary)));
  if (summary.tunnel_count > 0) {
    absl::StrAppend(&body, "<h2>Tunnels</h2>\n", HtmlTable(TunnelRows(report)));
  }
  if (summary.alias_count > 0) {
    absl::StrAppend(&body, "<h2>Places that look like others</h2>\n", HtmlTable(AliasRows(report)));
  }
  return HtmlPage(absl::StrCat("Map ", report.map->info().name), body);
}

}  // namespace dcloc::cli
