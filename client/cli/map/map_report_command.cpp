#include "client/cli/map/map_report_command.h"

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/output_file.h"
#include "client/cli/common/stage_line.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/localizability_report.h"
#include "client/cli/map/map_files.h"
#include "client/simulation/radar/radar_profile.h"

namespace dcloc::cli {
namespace {

struct ReportArguments {
  std::string file;
  int radar_count = 1;
  LocalizabilityOptions options;
  std::string out;
  std::string map_out;
  bool force = false;
  bool json = false;
};

Rig RigOf(int radar_count) {
  return simulation::MakeRig(simulation::Ars408Profile(), radar_count, 0.0, false, 0.0);
}

/// The map with what vehicles can expect at each keyframe.
absl::Status WriteMap(const LocalizabilityReport& report, const std::string& file) {
  if (file.empty()) return absl::OkStatus();
  EditableMap map = ToEditable(*report.map);
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    map.keyframes[i].record.accuracy = PackAccuracy(AccuracyOf(report.keyframes[i]));
  }
  return WriteMapParts(map, file).status();
}

absl::Status MakeReport(const ReportArguments& arguments) {
  absl::Status status = CheckOutputFiles({{arguments.out, arguments.map_out}, arguments.force});
  status.Update(CheckFolders({arguments.out, arguments.map_out}));
  if (!status.ok()) return status;
  LocalizabilityReport report{.file = arguments.file};
  auto map = RadarMap::Open(arguments.file);
  if (!map.ok()) return map.status();
  report.map = *std::move(map);
  if (status = report.map->Verify(); !status.ok()) {
    return absl::Status(status.code(), absl::StrCat(arguments.file, ": ", status.message()));
  }
  LocalizabilityOptions options = arguments.options;
  options.vehicle.rig = RigOf(arguments.radar_count);
  StageLine line;
  auto keyframes = ComputeLocalizability(report.map, options, [&](double share) {
    line.Update("driving through the map", share);
    return true;
  });
  if (!keyframes.ok()) return keyframes.status();
  report.keyframes = *std::move(keyframes);
  if (!arguments.out.empty()) {
    const std::string page = LocalizabilityHtml(report);
    status = WriteFileAtomically(arguments.out, std::as_bytes(std::span(page)));
  }
  if (status.ok()) status = WriteMap(report, arguments.map_out);
  absl::PrintF("%s", arguments.json ? LocalizabilityJson(report).dump(2) + "\n"
                                    : LocalizabilityText(report));
  return status;
}

}  // namespace

void AddMapReportCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<ReportArguments>();
  LocalizabilityOptions& options = arguments->options;
  CLI::App* report = map_command.add_subcommand(
      "report", "Say how well vehicles can know where they are in a map, place by place");
  report->add_option("file", arguments->file, "Map file")->required()->type_name("FILE");
  report
      ->add_option("--radars", arguments->radar_count,
                   "Of the vehicle: one that looks ahead, or five all around")
      ->check(CLI::IsMember({1, 5}))
      ->capture_default_str();
  report->add_option("--speed-mps", options.vehicle.speed_mps, "Of the vehicle")
      ->check(CLI::Range(0.5, 60.0))
      ->type_name("MPS")
      ->capture_default_str();
  report
      ->add_option("--alias-radius-m", options.aliases.radius_m,
                   "Hold each place against all within this distance; 0: against none")
      ->check(CLI::Range(0.0, 1e7))
      ->type_name("M")
      ->capture_default_str();
  report->add_option("--out", arguments->out, "Page to write, with a drawing")->type_name("HTML");
  report
      ->add_option("--map-out", arguments->map_out,
                   "Map file to write: the same with what vehicles can expect at each keyframe, as "
                   "`coverage` and `tile` tell it")
      ->type_name("FILE");
  AddForceOption(*report, arguments->force);
  report->add_flag("--json", arguments->json, "Print as JSON, a row for each keyframe");
  report->footer(
      "A vehicle is driven along the keyframes. It sees what the map holds, with the noise of\n"
      "its radars, and is localized as on the road. Deviations are those that it is told.\n"
      "Example:\n"
      "  dcloc map report town.dclm --out town.html\n"
      "With --map-out a planner can ask a server how well a vehicle will know where it "
      "is.\n"
      "Earlier servers refuse such a file.");
  OnRun(*report, arguments, exit_code, &MakeReport);
}

}  // namespace dcloc::cli
