#include "client/cli/map/map_update_command.h"

#include <memory>

#include "client/cli/common/on_run.h"
#include "client/cli/common/output_file.h"
#include "client/cli/map/update_run.h"

namespace dcloc::cli {

void AddMapUpdateCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<UpdateArguments>();
  CLI::App* app = map_command.add_subcommand(
      "update", "Bring a map up to date by later drives; write it if it is better");
  app->add_option("--base", arguments->base, "The map's present version")
      ->required()
      ->type_name("FILE");
  AddDatasetOptions(*app, arguments->dataset);
  app->add_option("--drive", arguments->drives,
                  "Drives over the map, of two vehicles or days at least")
      ->required()
      ->delimiter(',')
      ->type_name("NAME,...");
  AddRadarsOption(*app, "--radars", arguments->request.radars, "Radars to use; all by default");
  AddDriveRequestOptions(*app, arguments->request);
  app->add_option("--keep-out", arguments->held_out,
                  "The drive that judges the new version, and has no part in it; the last one of "
                  "--drive by default")
      ->type_name("NAME");
  app->add_option("--base-age-days", arguments->options.base_age_days,
                  "Age of the base map at the first drive")
      ->check(CLI::Range(0.0, 36500.0))
      ->type_name("DAYS")
      ->capture_default_str();
  app->add_option("--out", arguments->out, "Map file to write")->required()->type_name("FILE");
  app->add_option("--report", arguments->report, "Page to write on what has changed")
      ->type_name("HTML");
  AddForceOption(*app, arguments->force);
  app->add_flag("--json", arguments->json, "Print what has changed as JSON");
  app->footer(
      "The file is written only if the drive that is kept out is localized as accurately, as a\n"
      "whole and in every street segment, and fits better. Streets that two drives of different\n"
      "vehicles or days went on beyond the map join it; where the rest is worse, they join alone.\n"
      "Example, a town that is driven through a month later:\n"
      "  dcloc simulate --out sim --replaced 0.1 --vehicles 4 --live-speed-kmh 50,40,60,45\n"
      "  dcloc map build --dataset nuscenes --root sim --drive map --out may.dclm\n"
      "  dcloc map update --base may.dclm --dataset nuscenes --root sim \\\n"
      "      --drive live-0,live-1,live-2,live-3 --out june.dclm --report june.html");
  OnRun(*app, arguments, exit_code, &RunUpdate);
}

}  // namespace dcloc::cli
