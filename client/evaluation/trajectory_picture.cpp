#include "client/evaluation/trajectory_picture.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/evaluation/plot_data.h"
#include "client/trajectory/trajectory_error.h"

namespace dcloc {
namespace {

// Colours that most kinds of colour blindness tell apart.
constexpr std::array kTrackColours = {"#0072B2", "#D55E00", "#009E73",
                                      "#CC79A7", "#E69F00", "#56B4E9"};
constexpr double kGap_s = 1.0;  ///< a curve of errors breaks here

constexpr int kWidth_px = 1200;
constexpr double kPlotWidth_px = 1100.0;  ///< within the axes
constexpr double kMinTracks_px = 250.0;
constexpr double kMaxTracks_px = 1000.0;
constexpr int kAroundTracks_px = 130;  ///< labels and legend
constexpr int kErrors_px = 260;

/// A single pose is no line.
const char* CurveStyle(const Trajectory& trajectory) {
  return trajectory.poses.size() > 1 ? "lines lw 1.6" : "points pt 7 ps 1.5";
}

std::vector<std::string> TrajectoryLines(const Trajectory& trajectory) {
  std::vector<std::string> lines;
  lines.reserve(trajectory.poses.size());
  for (const TrajectoryPose& entry : trajectory.poses) {
    const Eigen::Vector3d& t = entry.T_map_vehicle.translation_m;
    lines.push_back(absl::StrFormat("%.3f %.3f", t.x(), t.y()));
  }
  return lines;
}

/// time, position error, heading error.
std::vector<std::string> TrajectoryErrorLines(const Trajectory& trajectory,
                                              const Trajectory& reference) {
  std::vector<std::string> lines;
  double previous_s = 0.0;
  for (const TrajectoryPair& pair : PairByStamp(trajectory, reference)) {
    const PoseOffset off = OffsetOf(pair);
    const double time_s =
        std::chrono::duration<double>(pair.stamp - reference.poses.front().stamp).count();
    if (!lines.empty() && time_s - previous_s > kGap_s) lines.emplace_back();
    lines.push_back(absl::StrFormat("%.4f %.4f %.4f", time_s, off.position_m, off.heading_deg));
    previous_s = time_s;
  }
  return lines;
}

/// The files' names, as the trajectories are called by their paths; the paths where names are
/// equal.
std::vector<std::string> LegendNames(const std::vector<Trajectory>& trajectories) {
  std::vector<std::string> names;
  std::vector<std::string> paths;
  for (const Trajectory& trajectory : trajectories) {
    names.push_back(std::filesystem::path(trajectory.name).filename().string());
    paths.push_back(trajectory.name);
  }
  const bool are_distinct =
      std::set<std::string>(names.begin(), names.end()).size() == names.size();
  return are_distinct ? names : paths;
}

std::string TrajectoryCurves(const char* block, const char* columns,
                             const std::vector<Trajectory>& trajectories) {
  const std::vector<std::string> names = LegendNames(trajectories);
  std::vector<std::string> curves;
  for (std::size_t i = 0; i < names.size(); ++i) {
    curves.push_back(absl::StrFormat("$%s%d using %s with %s lc rgb '%s' title %s", block, i,
                                     columns, CurveStyle(trajectories[i]),
                                     kTrackColours[i % kTrackColours.size()], Quote(names[i])));
  }
  return absl::StrJoin(curves, ", ");
}

/// What the tracks cover, with a margin, and never without extent.
Box TracksBox(const std::vector<Trajectory>& trajectories,
              const std::optional<Trajectory>& reference) {
  Box box;
  const auto add = [&](const Trajectory& trajectory) {
    for (const TrajectoryPose& entry : trajectory.poses) box.Add(Position(entry.T_map_vehicle));
  };
  for (const Trajectory& trajectory : trajectories) add(trajectory);
  if (reference) add(*reference);
  return box.Grown(std::max(1.0, 0.03 * (box.max - box.min).maxCoeff()));
}

/// Panels from the top down, in a picture that is as high as they need.
class Panels {
 public:
  /// `size` says how the panel fills its place.
  void Add(int height_px, const std::string& size, const std::string& commands) {
    panels_.push_back({height_px, size, commands});
    height_px_ += height_px;
  }

  Picture Draw(const std::string& data) const {
    std::string commands =
        absl::StrCat(data, "set multiplot\nset grid back lt 1 lc rgb '#d8d8d8'\n");
    int below_px = height_px_;
    for (const Panel& panel : panels_) {
      below_px -= panel.height_px;
      absl::StrAppendFormat(&commands, "set origin 0,%.4f\nset size noratio\nset size 1,%.4f\n%s%s",
                            Share(below_px), Share(panel.height_px), panel.size, panel.commands);
    }
    return {
        .commands = commands + "unset multiplot\n", .width_px = kWidth_px, .height_px = height_px_};
  }

 private:
  struct Panel {
    int height_px;
    std::string size;
    std::string commands;
  };

  double Share(int height_px) const { return static_cast<double>(height_px) / height_px_; }

  std::vector<Panel> panels_;
  int height_px_ = 0;
};

void AddTracks(const Box& box, const std::string& curves, Panels& panels) {
  const Eigen::Vector2d extent = box.max - box.min;
  const double wanted_px = kPlotWidth_px * extent.y() / extent.x();
  const int height_px = static_cast<int>(std::clamp(wanted_px, kMinTracks_px, kMaxTracks_px));
  panels.Add(height_px + kAroundTracks_px, "set size ratio -1\n",
             absl::StrFormat("set xrange [%.3f:%.3f]\nset yrange [%.3f:%.3f]\n"
                             "set xlabel 'x_{map} [m]'\nset ylabel 'y_{map} [m]'\n"
                             "set key outside top center horizontal noenhanced\nplot %s\n",
                             box.min.x(), box.max.x(), box.min.y(), box.max.y(), curves));
}

void AddErrors(const char* quantity, const char* columns,
               const std::vector<Trajectory>& trajectories, Panels& panels) {
  panels.Add(kErrors_px, "",
             absl::StrFormat("unset key\nset xlabel 'time [s]'\nset ylabel '%s'\n"
                             "set xrange [0:*]\nset yrange [0:*]\nplot %s\n",
                             quantity, TrajectoryCurves("error", columns, trajectories)));
}

}  // namespace

Picture DrawTrajectories(const std::vector<Trajectory>& trajectories,
                         const std::optional<Trajectory>& reference) {
  std::string data;
  std::string tracks = TrajectoryCurves("track", "1:2", trajectories);
  for (std::size_t i = 0; i < trajectories.size(); ++i) {
    absl::StrAppend(&data, Block(absl::StrCat("track", i), TrajectoryLines(trajectories[i])));
    if (!reference) continue;
    // gnuplot takes no block without a point.
    std::vector<std::string> errors = TrajectoryErrorLines(trajectories[i], *reference);
    if (errors.empty()) errors.emplace_back("0 NaN NaN");
    absl::StrAppend(&data, Block(absl::StrCat("error", i), errors));
  }
  if (reference) {
    absl::StrAppend(&data, Block("reference", TrajectoryLines(*reference)));
    tracks = absl::StrCat(
        "$reference using 1:2 with lines lw 3.5 lc rgb '#000000' title 'reference', ", tracks);
  }
  Panels panels;
  AddTracks(TracksBox(trajectories, reference), tracks, panels);
  if (reference) {
    AddErrors("position error [m]", "1:2", trajectories, panels);
    AddErrors("heading error [deg]", "1:3", trajectories, panels);
  }
  return panels.Draw(data);
}

}  // namespace dcloc
