#include "client/cli/map/map_survey_command.h"

#include <memory>

#include "client/cli/common/anchor_option.h"
#include "client/cli/common/calibration_option.h"
#include "client/cli/common/on_run.h"
#include "client/cli/map/survey_run.h"

namespace dcloc::cli {

void AddMapSurveyCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<SurveyArguments>();
  CLI::App* app = map_command.add_subcommand(
      "survey", "Make a map of drives whose poses are not known, from their scans alone");
  AddDatasetOptions(*app, arguments->dataset);
  app->add_option("--drive", arguments->drives, "Drives to survey: scenes or sequences")
      ->required()
      ->delimiter(',')
      ->type_name("NAME,...");
  AddRadarsOption(*app, "--radars", arguments->request.radars,
                  "Radars to survey with; all by default");
  AddDriveRequestOptions(*app, arguments->request);
  CLI::Option* gnss =
      app->add_option("--gnss", arguments->fix_files,
                      "Position fixes, as `dcloc localize --fixes` reads them; of any of the "
                      "drives, by their stamps")
          ->delimiter(',')
          ->check(CLI::ExistingFile)
          ->type_name("CSV,...");
  AddAnchorOption(*app, arguments->anchor)->needs(gnss);
  AddKeepOption(*app, arguments->keep);
  app->add_flag("--no-calibration", arguments->no_calibration,
                "Take the radars as they are described");
  app->add_option("--rig-out", arguments->rig_out,
                  "Write what was found wrong with the radars as a rig file, which --rig takes")
      ->excludes("--no-calibration")
      ->type_name("FILE");
  app->add_option("--name", arguments->name, "Name of the map; the first drive's by default");
  app->add_option("--out", arguments->out, "Map file to write")->required()->type_name("FILE");
  app->add_option("--report", arguments->report, "Page to write on drives and loops")
      ->type_name("HTML");
  app->add_option("--checkpoint", arguments->checkpoint,
                  "Keep there what each stage found, and in FILE.1, FILE.2 after calibrations. A "
                  "survey that was stopped goes on from them; they go once the map is written")
      ->type_name("FILE");
  AddTrajectoryOptions(*app, arguments->trajectory);
  app->add_flag("--compare-truth", arguments->compare_truth,
                "Say how far the result is from the data set's reference poses, which the survey "
                "itself does not use");
  app->add_flag("--json", arguments->json, "Print what was found as JSON");
  app->footer(
      "With fixes the map is in their frame, otherwise in one that begins at the first node.\n"
      "Mounts, clocks, beta and range biases of the radars are estimated along with it, as far as\n"
      "the drives tell; what they tell of all clocks together is left as described.\n"
      "Example, a simulated town that is driven through four times:\n"
      "  dcloc simulate --out sim --loop-m 1500 --length-m 3000 --rig 5 \\\n"
      "      --live-speed-kmh 40,50,30\n"
      "  dcloc map survey --dataset nuscenes --root sim --drive map,live-0,live-1,live-2 \\\n"
      "      --out town.dclm --report town.html --compare-truth\n"
      "`dcloc map report` says how well vehicles can know where they are in the map.");
  OnRun(*app, arguments, exit_code, &RunSurvey);
}

}  // namespace dcloc::cli
