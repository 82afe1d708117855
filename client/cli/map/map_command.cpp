#include "client/cli/map/map_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/anchor_option.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/progress.h"
#include "client/cli/map/map_align_command.h"
#include "client/cli/map/map_diff_command.h"
#include "client/cli/map/map_edit_command.h"
#include "client/cli/map/map_exchange_command.h"
#include "client/cli/map/map_report.h"
#include "client/cli/map/map_report_command.h"
#include "client/cli/map/map_survey_command.h"
#include "client/cli/map/map_update_command.h"
#include "client/datasets/drive_map.h"

namespace dcloc::cli {
namespace {

struct BuildArguments {
  DatasetArguments dataset;
  DriveRequest drive;
  std::optional<GeodeticAnchor> anchor;
  std::string name;
  std::string out;
  bool json = false;
};

struct InspectArguments {
  std::string file;
  bool json = false;
};

void Print(const MapInfo& info, bool json) {
  absl::PrintF("%s", json ? absl::StrCat(MapInfoJson(info).dump(2), "\n") : MapInfoText(info));
}

std::string Describe(const BuildArguments& arguments, const Drive& drive) {
  std::vector<std::string> radars;
  for (const RadarModel& radar : drive.rig.radars) {
    radars.push_back(absl::StrFormat("%s (beta %g s)", radar.id, radar.beta_s));
  }
  return absl::StrCat("dcloc map build: ", arguments.dataset.format, " ", drive.name, ", ",
                      absl::StrJoin(radars, ", "));
}

absl::Status Build(const BuildArguments& arguments) {
  const auto drive = ReadDrive(arguments.dataset, arguments.drive);
  if (!drive.ok()) return drive.status();
  MapBuilderOptions options;
  options.name = arguments.name.empty() ? drive->name : arguments.name;
  options.description = Describe(arguments, *drive);
  options.anchor = arguments.anchor;
  Progress progress("building the map", drive->scans.size());
  auto bytes =
      BuildMap(*drive, options, [&](std::size_t scan_count) { progress.Update(scan_count); });
  if (!bytes.ok()) return bytes.status();
  if (absl::Status status = WriteFileAtomically(arguments.out, *bytes); !status.ok()) return status;
  const auto map = RadarMap::FromBytes(*std::move(bytes));
  if (!map.ok()) return map.status();
  Print((*map)->info(), arguments.json);
  return absl::OkStatus();
}

absl::Status Inspect(const InspectArguments& arguments) {
  const auto map = RadarMap::Open(arguments.file);
  if (!map.ok()) return map.status();
  if (absl::Status status = (*map)->Verify(); !status.ok()) {
    return absl::Status(status.code(), absl::StrCat(arguments.file, ": ", status.message()));
  }
  Print((*map)->info(), arguments.json);
  return absl::OkStatus();
}

void AddBuild(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<BuildArguments>();
  CLI::App* build = map.add_subcommand("build", "Make a map of a recorded drive");
  AddDatasetOptions(*build, arguments->dataset);
  build->add_option("--drive", arguments->drive.name, "Drive to map: scene or sequence")
      ->required()
      ->type_name("NAME");
  AddRadarsOption(*build, "--radars", arguments->drive.radars,
                  "Radars to map with; all by default");
  AddDriveRequestOptions(*build, arguments->drive);
  AddAnchorOption(*build, arguments->anchor);
  build->add_option("--name", arguments->name, "Name of the map; the drive's by default");
  build->add_option("--out", arguments->out, "File to write")->required()->type_name("FILE");
  build->add_flag("--json", arguments->json, "Print what was made as JSON");
  build->footer(
      "Example:\n  dcloc map build --dataset nuscenes --root ~/nuscenes --drive scene-0655 \\\n"
      "      --radars RADAR_FRONT,RADAR_FRONT_LEFT,RADAR_FRONT_RIGHT --out scene-0655.dclm");
  OnRun(*build, arguments, exit_code, &Build);
}

void AddInspect(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<InspectArguments>();
  CLI::App* inspect = map.add_subcommand("inspect", "Verify a map file and say what it is");
  inspect->add_option("file", arguments->file, "Map file")->required()->type_name("FILE");
  inspect->add_flag("--json", arguments->json, "Print as JSON");
  inspect->footer("Example:\n  dcloc map inspect scene-0655.dclm");
  OnRun(*inspect, arguments, exit_code, &Inspect);
}

}  // namespace

void AddMapCommand(CLI::App& app, int& exit_code) {
  CLI::App* map = app.add_subcommand("map", "Make, inspect and manage maps");
  map->require_subcommand(1);
  AddBuild(*map, exit_code);
  AddMapSurveyCommand(*map, exit_code);
  AddMapUpdateCommand(*map, exit_code);
  AddInspect(*map, exit_code);
  AddMapEditCommands(*map, exit_code);
  AddMapReportCommand(*map, exit_code);
  AddMapAlignCommand(*map, exit_code);
  AddMapDiffCommand(*map, exit_code);
  AddMapExchangeCommands(*map, exit_code);
}

}  // namespace dcloc::cli
