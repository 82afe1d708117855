#include "client/evaluation/paper/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/paper/comparison.h"
#include "client/evaluation/paper/statistics.h"
#include "client/evaluation/plot_data.h"

namespace dcloc::paper {
namespace {

// Colours that most kinds of colour blindness tell apart; the last is ours.
constexpr std::array kColours = {"#999999", "#DDCC77", "#E69F00", "#CC79A7",
                                 "#56B4E9", "#009E73", "#0072B2", "#D55E00"};

// Table I but for the calibrated row: curves of what knows the same.
std::vector<RowPlan> MethodRows() {
  std::vector<RowPlan> rows = Table1Rows();
  std::erase_if(rows, [](const RowPlan& row) { return row.variant.calibrated; });
  return rows;
}

// Of `count` curves, the last ones of the palette.
const char* Colour(std::size_t index, std::size_t count) {
  return kColours.at(kColours.size() - std::min(count, kColours.size()) + index % kColours.size());
}

// Ours thick; ours with a calibrated rig, where it stands below, dashed.
std::string Style(std::size_t index, const std::vector<RowPlan>& rows) {
  const std::size_t count = rows.size() - (rows.back().variant.calibrated ? 1 : 0);
  const bool is_ours = rows[index].variant.method == MethodKind::kDcloc;
  return absl::StrFormat("lc rgb '%s' lw %s pt %s", Colour(std::min(index, count - 1), count),
                         is_ours ? "3.5" : "1.8", rows[index].variant.calibrated ? "6 dt 2" : "7");
}

std::vector<DriveOutcome> OutcomesOf(std::span<const RunResult> results, const std::string& set,
                                     const Variant& variant) {
  std::vector<DriveOutcome> outcomes;
  for (const RunResult* result : ResultsOf(results, set, variant, Protocol::kTrack)) {
    outcomes.push_back(result->outcome);
  }
  return outcomes;
}

// Blocks "<prefix>0", ... of the rows' errors by speed difference: middle of the bin, mean RTE,
// mean RRE, median RTE, median RRE. False when all are empty.
bool AddSpeedBlocks(std::span<const RunResult> results, const std::string& set,
                    const std::vector<RowPlan>& rows, const std::string& prefix,
                    std::string& data) {
  bool has_data = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<std::string> lines;
    const auto outcomes = OutcomesOf(results, set, rows[i].variant);
    for (const SpeedBin& bin : ErrorsBySpeedDifference(outcomes)) {
      lines.push_back(absl::StrFormat("%g %.5f %.5f %.5f %.5f", 0.5 * (bin.begin_mps + bin.end_mps),
                                      bin.rte_mean_m, bin.rre_mean_deg, bin.rte_median_m,
                                      bin.rre_median_deg));
    }
    has_data = has_data || !lines.empty();
    data += Block(absl::StrCat(prefix, i), lines);
  }
  return has_data;
}

std::string SpeedCurves(const std::vector<RowPlan>& rows, const std::string& prefix, int column) {
  std::vector<std::string> curves;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    curves.push_back(absl::StrFormat("$%s%d using 1:%d with linespoints ps 0.8 %s title %s", prefix,
                                     i, column, Style(i, rows), Quote(rows[i].label)));
  }
  return "plot " + absl::StrJoin(curves, ", ") + "\n";
}

constexpr const char* kGrid = "set grid back lt 1 lc rgb '#d8d8d8' lw 0.6\n";

// Line of quantiles of a row's errors: place, 25, 5, 95, 75 and 50 %, as candlesticks take them.
std::string QuantileLine(std::size_t place, const std::vector<double>& errors) {
  return absl::StrFormat("%d %.5f %.5f %.5f %.5f %.5f", place, Quantile(errors, 0.25),
                         Quantile(errors, 0.05), Quantile(errors, 0.95), Quantile(errors, 0.75),
                         Quantile(errors, 0.5));
}

std::string Candles(const std::vector<RowPlan>& rows, const char* prefix, const char* title,
                    const char* unit) {
  std::vector<std::string> tics;
  std::vector<std::string> candles;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    tics.push_back(absl::StrFormat("%s %d", Quote(rows[i].label), i));
    candles.push_back(absl::StrFormat(
        "$%s%d using 1:2:3:4:5 with candlesticks whiskerbars 0.6 fc rgb '%s' fs solid 0.5 border "
        "lc rgb 'black' notitle, $%s%d using 1:6:6:6:6 with candlesticks lw 2.5 lc rgb 'black' "
        "notitle",
        prefix, i, Colour(i, rows.size()), prefix, i));
  }
  return absl::StrCat("set title '", title, "'\nset ylabel '", unit, "'\nset logscale y\n",
                      "set boxwidth 0.5\nset xtics rotate by 25 right (", absl::StrJoin(tics, ", "),
                      ")\nset xrange [-0.7:", rows.size() - 1, ".7]\nplot ",
                      absl::StrJoin(candles, ", "), "\n");
}

// x, y of the answers within `box`; an empty line where the vehicle was elsewhere.
std::vector<std::string> PathLines(const DriveOutcome& outcome, const Box& box, bool is_truth) {
  std::vector<std::string> lines;
  for (const ScanOutcome& scan : outcome.scans) {
    if (!scan.answered() || !box.Contains(Position(scan.T_map_vehicle_true))) {
      if (!lines.empty() && !lines.back().empty()) lines.emplace_back();
      continue;
    }
    const Eigen::Vector2d p =
        Position(is_truth ? scan.T_map_vehicle_true : scan.answer.T_map_vehicle);
    lines.push_back(absl::StrFormat("%.4f %.4f", p.x(), p.y()));
  }
  return lines;
}

const ScanOutcome* WorstScan(const DriveOutcome& outcome) {
  const ScanOutcome* worst = nullptr;
  for (const ScanOutcome& scan : outcome.scans) {
    if (!scan.answered()) continue;
    if (worst == nullptr || scan.error.translation_m > worst->error.translation_m) worst = &scan;
  }
  return worst;
}

/// The panels of Fig. 12.
class TrackFigure {
 public:
  TrackFigure(std::string set, std::vector<RowPlan> rows, std::vector<const DriveOutcome*> outcomes)
      : set_(std::move(set)), rows_(std::move(rows)), outcomes_(std::move(outcomes)) {}

  std::string Compose() {
    const DriveOutcome& ours = *outcomes_.back();
    const Box whole = TrackBox(ours).Grown(10.0);
    std::string panels = absl::StrCat("set size 1,0.41\nset origin 0,0.54\n",
                                      Panel(whole, "The whole track of " + ours.drive),
                                      "unset key\nset size 0.5,0.55\n");
    // Where the paper's methods are worst, not ours alone.
    for (std::size_t i = 0; i + 1 < rows_.size() && i < 2; ++i) {
      const ScanOutcome* worst = WorstScan(*outcomes_[i]);
      if (worst == nullptr) continue;
      const Eigen::Vector2d centre = Position(worst->T_map_vehicle_true);
      const double half_m = std::clamp(2.5 * worst->error.translation_m, 1.5, 8.0);
      absl::StrAppend(
          &panels, "set origin ", 0.5 * static_cast<double>(i), ",0\n",
          Panel(Box{centre, centre}.Grown(half_m), "Around the worst of " + rows_[i].label));
    }
    return absl::StrCat(data_, kGrid, "set multiplot title ", Quote("Fig. 12: " + set_),
                        "\nset xtics rotate by 30 right\nset key outside right top ",
                        "vertical Left reverse\n", panels, "unset multiplot\n");
  }

 private:
  std::string Panel(const Box& box, const std::string& title) {
    const std::string prefix = absl::StrCat("panel", panel_count_++, "_");
    data_ += Block(prefix + "truth", PathLines(*outcomes_.back(), box.Grown(5.0), true));
    std::vector<std::string> curves = {absl::StrCat(
        "$", prefix, "truth using 1:2 with lines lw 5 lc rgb '#bbbbbb' title 'truth'")};
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const std::string block = absl::StrCat(prefix, i);
      data_ += Block(block, PathLines(*outcomes_[i], box.Grown(5.0), false));
      curves.push_back(absl::StrFormat("$%s using 1:2 with linespoints ps 0.3 %s title %s", block,
                                       Style(i, rows_), Quote(rows_[i].label)));
    }
    return absl::StrFormat(
        "set size ratio -1\nset title %s noenhanced\nset xlabel 'x [m]'\nset ylabel 'y [m]'\n"
        "set xrange [%.3f:%.3f]\nset yrange [%.3f:%.3f]\nplot %s\n",
        Quote(title), box.min.x(), box.max.x(), box.min.y(), box.max.y(),
        absl::StrJoin(curves, ", "));
  }

  std::string set_;
  std::vector<RowPlan> rows_;
  std::vector<const DriveOutcome*> outcomes_;
  std::string data_;
  int panel_count_ = 0;
};

}  // namespace

std::optional<Picture> DrawSpeedFigure(std::span<const RunResult> results, const std::string& set) {
  const std::vector<RowPlan> rows = MethodRows();
  std::string data;
  if (!AddSpeedBlocks(results, set, rows, "row", data)) return std::nullopt;
  const std::string commands = absl::StrCat(
      data, kGrid, "set multiplot layout 1,2 margins 0.06,0.82,0.11,0.86 spacing 0.07 title ",
      Quote("Fig. 9: " + set + "; right answers, bins of 2 m/s"), "\n",
      "set key at screen 0.83,0.86 left top vertical Left reverse samplen 2 maxrows 10\n",
      "set xlabel '|speed difference| [m/s]'\nset xrange [0:*]\nset yrange [0:*]\n",
      "set title 'mean translation error'\nset ylabel '[m]'\n", SpeedCurves(rows, "row", 2),
      "unset key\nset title 'mean rotation error'\nset ylabel '[deg]'\n",
      SpeedCurves(rows, "row", 3), "unset multiplot\n");
  return Picture{.commands = commands, .width_px = 1400, .height_px = 620};
}

std::optional<Picture> DrawDistributionFigure(std::span<const RunResult> results,
                                              const std::string& set) {
  std::string data;
  std::vector<RowPlan> rows;
  for (const RowPlan& row : MethodRows()) {
    std::vector<double> rte_m;
    std::vector<double> rre_deg;
    for (const DriveOutcome& outcome : OutcomesOf(results, set, row.variant)) {
      for (const ScanOutcome& scan : outcome.scans) {
        if (!scan.answered()) continue;
        rte_m.push_back(scan.error.translation_m);
        rre_deg.push_back(scan.error.rotation_deg);
      }
    }
    if (rte_m.empty()) continue;
    data += Block(absl::StrCat("rte", rows.size()), {QuantileLine(rows.size(), rte_m)}) +
            Block(absl::StrCat("rre", rows.size()), {QuantileLine(rows.size(), rre_deg)});
    rows.push_back(row);
  }
  if (rows.empty()) return std::nullopt;
  const std::string commands = absl::StrCat(
      data, kGrid, "set multiplot layout 1,2 title ", Quote("Fig. 10: " + set), "\n",
      Candles(rows, "rte", "translation error: 5, 25, 50, 75, 95 %", "[m]"),
      Candles(rows, "rre", "rotation error: 5, 25, 50, 75, 95 %", "[deg]"), "unset multiplot\n");
  return Picture{.commands = commands, .width_px = 1400, .height_px = 620};
}

std::optional<Picture> DrawNoiseFigure(std::span<const RunResult> results) {
  std::vector<RowPlan> rows = FigureRows();
  rows.push_back(NoiseRows().back());  // which knows of the noise's bias
  rows.back().label = "dcloc, calibrated";
  std::string data;
  std::string translation;
  std::string rotation;
  int noise_count = 0;
  for (const std::string& set : SetsOf(results)) {
    const std::string prefix = absl::StrCat("noise", noise_count, "_");
    if (!absl::StartsWith(set, "noise ") || !AddSpeedBlocks(results, set, rows, prefix, data)) {
      continue;
    }
    ++noise_count;
    translation += absl::StrCat("set title ", Quote(set), "\n", SpeedCurves(rows, prefix, 4),
                                "unset key\nunset ylabel\n");
    rotation += absl::StrCat(SpeedCurves(rows, prefix, 5), "unset ylabel\n");
  }
  if (noise_count == 0) return std::nullopt;
  const std::string commands = absl::StrCat(
      data, kGrid, "set multiplot layout 2,", noise_count,
      " margins 0.05,0.99,0.13,0.9 spacing 0.045,0.07 title "
      "'Fig. 11: right answers, bins of 2 m/s'\n",
      "set key at screen 0.5,0.03 center center vertical maxrows 1\n",
      "set xrange [0:*]\nset yrange [0:*]\nset ylabel 'median RTE [m]'\n", translation,
      "unset title\nset xlabel '|speed difference| [m/s]'\nset ylabel 'median RRE [deg]'\n",
      rotation, "unset multiplot\n");
  return Picture{.commands = commands, .width_px = 1500, .height_px = 900};
}

std::optional<Picture> DrawTrackFigure(std::span<const RunResult> results, const std::string& set) {
  const std::vector<RowPlan> rows = FigureRows();
  const auto ours = ResultsOf(results, set, rows.back().variant, Protocol::kTrack);
  const auto longest = std::ranges::max_element(ours, {}, [](const RunResult* result) {
    const Box box = TrackBox(result->outcome);
    return result->outcome.scans.empty() ? 0.0 : (box.max - box.min).norm();
  });
  if (longest == ours.end() ||
      std::ranges::none_of((*longest)->outcome.scans, &ScanOutcome::answered)) {
    return std::nullopt;
  }
  std::vector<const DriveOutcome*> outcomes;
  for (const RowPlan& row : rows) {
    for (const RunResult* result : ResultsOf(results, set, row.variant, Protocol::kTrack)) {
      if (result->case_name == (*longest)->case_name) outcomes.push_back(&result->outcome);
    }
  }
  if (outcomes.size() != rows.size()) return std::nullopt;
  return Picture{
      .commands = TrackFigure(set, rows, outcomes).Compose(), .width_px = 1400, .height_px = 900};
}

}  // namespace dcloc::paper
