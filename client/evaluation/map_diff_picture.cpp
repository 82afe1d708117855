#include "client/evaluation/map_diff_picture.h"

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/plot_data.h"

namespace dcloc {
namespace {

std::vector<std::string> ChangeLines(const std::vector<LandmarkChange>& landmarks, Box& box) {
  std::vector<std::string> lines;
  lines.reserve(landmarks.size());
  for (const LandmarkChange& landmark : landmarks) {
    box.Add(landmark.p_map.head<2>());
    lines.push_back(absl::StrFormat("%.2f %.2f", landmark.p_map.x(), landmark.p_map.y()));
  }
  return lines;
}

std::vector<std::string> MoveLines(const std::vector<LandmarkMove>& moves, Box& box) {
  std::vector<std::string> lines;
  lines.reserve(moves.size());
  for (const auto& [before, after] : moves) {
    const Eigen::Vector3d way_m = after.p_map - before.p_map;
    box.Add(after.p_map.head<2>());
    lines.push_back(absl::StrFormat("%.2f %.2f %.3f %.3f", before.p_map.x(), before.p_map.y(),
                                    way_m.x(), way_m.y()));
  }
  return lines;
}

}  // namespace

Picture DrawMapDiff(const MapDiff& diff) {
  Box box;
  std::string data;
  std::vector<std::string> curves;
  // gnuplot takes no block without a point; what is empty keeps its place in the legend.
  const auto add = [&](const char* name, std::vector<std::string> lines, std::size_t count,
                       const char* style) {
    if (lines.empty()) lines.emplace_back("NaN NaN NaN NaN");
    absl::StrAppend(&data, Block(name, lines));
    curves.push_back(absl::StrFormat("$%s %s title '%s: %d'", name, style, name, count));
  };
  add("same", ChangeLines(diff.same, box), diff.same.size(),
      "using 1:2 with points pt 7 ps 0.25 lc rgb '#b0b0b0'");
  add("went", ChangeLines(diff.removed, box), diff.removed.size(),
      "using 1:2 with points pt 2 ps 0.7 lw 1.5 lc rgb '#D55E00'");
  add("came", ChangeLines(diff.added, box), diff.added.size(),
      "using 1:2 with points pt 1 ps 0.7 lw 1.5 lc rgb '#0072B2'");
  add("moved", MoveLines(diff.moved, box), diff.moved.size(),
      "using 1:2:3:4 with vectors nohead lw 2 lc rgb '#009E73'");
  if (box.min.x() > box.max.x()) box.Add(Eigen::Vector2d::Zero());
  box = box.Grown(10.0);
  const Eigen::Vector2d extent = box.max - box.min;
  const int height_px =
      static_cast<int>(std::clamp(1100.0 * extent.y() / extent.x(), 250.0, 1000.0)) + 130;
  std::string plot;
  for (const std::string& curve : curves) absl::StrAppend(&plot, plot.empty() ? "" : ", ", curve);
  return {
      .commands = absl::StrFormat("%sset grid back lt 1 lc rgb '#d8d8d8'\nset size ratio -1\n"
                                  "set xrange [%.3f:%.3f]\nset yrange [%.3f:%.3f]\n"
                                  "set xlabel 'x_{map} [m]'\nset ylabel 'y_{map} [m]'\n"
                                  "set key outside top center horizontal noenhanced\nplot %s\n",
                                  data, box.min.x(), box.max.x(), box.min.y(), box.max.y(), plot),
      .width_px = 1200,
      .height_px = height_px};
}

}  // namespace dcloc
