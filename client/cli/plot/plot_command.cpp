#include "client/cli/plot/plot_command.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/terminal.h"
#include "client/evaluation/metrics.h"
#include "client/evaluation/trajectory_picture.h"
#include "client/trajectory/trajectory_error.h"
#include "client/trajectory/trajectory_reader.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct PlotArguments {
  std::vector<std::string> files;
  std::string format;  ///< of all files; empty: by extension
  std::string reference_file;
  std::string out;
  bool align = false;
  bool json = false;
};

/// What is told of a trajectory's errors.
struct Summary {
  std::string name;
  std::size_t pose_count = 0;
  TrajectoryError error;
  std::vector<double> positions_m;
  std::vector<double> headings_deg;
};

absl::StatusOr<Trajectory> Read(const std::string& file, const std::string& format_name) {
  const auto format = TrajectoryFormatOf(file, format_name);
  if (!format.ok()) return format.status();
  return ReadTrajectory(file, *format);
}

void Align(Trajectory& trajectory, const Trajectory& reference) {
  const Pose3 T_truth_map = Embed(AlignTrajectory(PairByStamp(trajectory, reference)));
  for (TrajectoryPose& entry : trajectory.poses) {
    entry.T_map_vehicle = T_truth_map * entry.T_map_vehicle;
  }
}

Summary Summarize(const Trajectory& trajectory, const Trajectory& reference) {
  const std::vector<TrajectoryPair> pairs = PairByStamp(trajectory, reference);
  Summary summary{.name = trajectory.name,
                  .pose_count = trajectory.poses.size(),
                  .error = ErrorOf(pairs, {}),
                  .positions_m = {},
                  .headings_deg = {}};
  for (const TrajectoryPair& pair : pairs) {
    const PoseOffset off = OffsetOf(pair);
    summary.positions_m.push_back(off.position_m);
    summary.headings_deg.push_back(off.heading_deg);
  }
  return summary;
}

ordered_json Json(const std::vector<double>& errors, double rmse) {
  return {{"median", Quantile(errors, 0.5)},
          {"rms", rmse},
          {"p95", Quantile(errors, 0.95)},
          {"max", std::ranges::max(errors)}};
}

std::string Text(const std::vector<double>& errors, double rmse) {
  return absl::StrFormat("%.3f / %.3f / %.3f / %.3f", Quantile(errors, 0.5), rmse,
                         Quantile(errors, 0.95), std::ranges::max(errors));
}

void Print(const std::vector<Summary>& summaries, bool as_json) {
  if (as_json) {
    ordered_json list = ordered_json::array();
    for (const Summary& summary : summaries) {
      list.push_back({{"file", summary.name},
                      {"pose_count", summary.pose_count},
                      {"compared_count", summary.positions_m.size()},
                      {"position_error_m", Json(summary.positions_m, summary.error.rmse_m)},
                      {"heading_error_deg", Json(summary.headings_deg, summary.error.rmse_deg)}});
    }
    absl::PrintF("%s\n", list.dump(2, ' ', false, ordered_json::error_handler_t::replace));
    return;
  }
  std::vector<std::vector<std::string>> rows = {{"", "poses", "compared",
                                                 "position median / rms / p95 / max [m]",
                                                 "heading median / rms / p95 / max [deg]"}};
  for (const Summary& summary : summaries) {
    rows.push_back({summary.name, absl::StrCat(summary.pose_count),
                    absl::StrCat(summary.positions_m.size()),
                    Text(summary.positions_m, summary.error.rmse_m),
                    Text(summary.headings_deg, summary.error.rmse_deg)});
  }
  absl::PrintF("%s", FormatTable(rows));
}

absl::Status Draw(const Picture& picture, const std::string& out) {
  if (out.empty()) return absl::OkStatus();
  if (absl::EndsWith(out, ".png")) return RenderPng(picture, out);
  const absl::StatusOr<std::string> svg = RenderSvg(picture);
  if (!svg.ok()) return svg.status();
  return WriteFileAtomically(out, std::as_bytes(std::span(*svg)));
}

absl::Status Run(const PlotArguments& arguments) {
  std::vector<Trajectory> trajectories;
  for (const std::string& file : arguments.files) {
    absl::StatusOr<Trajectory> trajectory = Read(file, arguments.format);
    if (!trajectory.ok()) return trajectory.status();
    trajectories.push_back(*std::move(trajectory));
  }
  std::optional<Trajectory> reference;
  if (!arguments.reference_file.empty()) {
    absl::StatusOr<Trajectory> read = Read(arguments.reference_file, arguments.format);
    if (!read.ok()) return read.status();
    reference = *std::move(read);
    std::vector<Summary> summaries;
    for (Trajectory& trajectory : trajectories) {
      if (arguments.align) Align(trajectory, *reference);
      summaries.push_back(Summarize(trajectory, *reference));
      if (!summaries.back().positions_m.empty()) continue;
      return absl::FailedPreconditionError(absl::StrCat(
          trajectory.name, ": none of its stamps lies within those of ", reference->name));
    }
    Print(summaries, arguments.json);
  }
  return Draw(DrawTrajectories(trajectories, reference), arguments.out);
}

std::string CheckPicture(const std::string& file) {
  if (absl::EndsWith(file, ".png") || absl::EndsWith(file, ".svg")) return "";
  return "must end with .svg or .png";
}

}  // namespace

void AddPlotCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PlotArguments>();
  CLI::App* plot =
      app.add_subcommand("plot", "Draw trajectories, and print how far they are from another one");
  plot->add_option("files", arguments->files, "Trajectories: TUM, or CSV with stamps")
      ->required()
      ->type_name("FILE");
  CLI::Option* reference =
      plot->add_option("--reference", arguments->reference_file,
                       "Trajectory that is true; errors are against it, between its poses")
          ->type_name("FILE");
  plot->add_option("--format", arguments->format, "Of the files, where an extension does not tell")
      ->check(CLI::IsMember({"tum", "csv"}));
  plot->add_flag("--align", arguments->align,
                 "Move and turn each trajectory in the plane so that it fits the reference best")
      ->needs(reference);
  CLI::Option* out = plot->add_option("--out", arguments->out, "The picture (needs gnuplot)")
                         ->check(CheckPicture)
                         ->type_name("SVG|PNG");
  plot->add_flag("--json", arguments->json, "Print the errors as JSON")->needs(reference);
  plot->footer(
      "All trajectories are in one map's frame, unless --align brings them there. `localize\n"
      "--out`, `--trajectory-out` and `dataset trajectory` write such files.\n"
      "Example:\n"
      "  dcloc plot live-0.tum answers.csv --reference truth.tum --out errors.svg");
  plot->callback([arguments, reference, out, &exit_code] {
    if (reference->count() == 0 && out->count() == 0) {
      throw CLI::RequiredError("At least one of --reference and --out");
    }
    const absl::Status status = Run(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

}  // namespace dcloc::cli
