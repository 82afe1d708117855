#include "client/cli/evaluate/evaluate_robustness_command.h"

#include <memory>

#include "client/cli/common/on_run.h"
#include "client/cli/evaluate/evaluate_robustness_run.h"

namespace dcloc::cli {

void AddEvaluateRobustnessCommand(CLI::App& evaluate, int& exit_code) {
  auto arguments = std::make_shared<RobustnessArguments>();
  CLI::App* robustness = evaluate.add_subcommand(
      "robustness", "Disturb drives, start from little or nothing, and judge every answer");
  robustness
      ->add_option("--out", arguments->folder, "Folder for the report; made where it is missing")
      ->required()
      ->type_name("DIR");
  robustness
      ->add_option("--data", arguments->data,
                   "nuScenes or RadarScenes, or a folder that holds them: evaluated, too")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
  robustness->add_option("--seed", arguments->seed, "Makes other worlds, drives and disturbances")
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("N")
      ->capture_default_str();
  robustness->add_flag("--quick", arguments->quick, "A few short drives: does everything work?");
  robustness->footer(
      "Writes report.html and results.json. Finished trials are kept in runs/: what was "
      "interrupted\ngoes on there when it is started again by the same program. Goals that are "
      "missed are printed;\nthey are no failure of the command.\n"
      "Example:\n  dcloc evaluate robustness --out robustness --data ~/nuscenes");
  // `evaluate` asks for its options only where it is to evaluate drives itself.
  robustness->preparse_callback([&evaluate](std::size_t) {
    for (CLI::Option* option : evaluate.get_options()) option->required(false);
  });
  OnRun(*robustness, arguments, exit_code, &RunRobustness);
}

}  // namespace dcloc::cli
