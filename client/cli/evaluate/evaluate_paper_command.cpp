#include "client/cli/evaluate/evaluate_paper_command.h"

#include <memory>

#include "client/cli/common/on_run.h"
#include "client/cli/evaluate/evaluate_paper_run.h"

namespace dcloc::cli {

void AddEvaluatePaperCommand(CLI::App& evaluate, int& exit_code) {
  auto arguments = std::make_shared<PaperArguments>();
  CLI::App* paper = evaluate.add_subcommand(
      "paper", "Repeat the evaluation of the DC-Loc++ paper and print its numbers beside ours");
  paper->add_option("--out", arguments->folder, "Folder for the report; made where it is missing")
      ->required()
      ->type_name("DIR");
  paper
      ->add_option("--data", arguments->data,
                   "nuScenes or RadarScenes, or a folder that holds them: evaluated, too")
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
  paper->add_flag("--quick", arguments->quick, "A few short drives: does everything work?");
  paper->add_flag("--keep-runs", arguments->keep_runs,
                  "Take all finished runs, of another build, too: another report of the same runs");
  paper->footer(
      "Writes report.html, its figures as PNG files, and results.json. Finished runs are kept in "
      "runs/:\nwhat was interrupted goes on there when it is started again by the same program.\n"
      "Example:\n  dcloc evaluate paper --out paper --data ~/nuscenes");
  // `evaluate` asks for its options only where it is to evaluate drives itself.
  paper->preparse_callback([&evaluate](std::size_t) {
    for (CLI::Option* option : evaluate.get_options()) option->required(false);
  });
  OnRun(*paper, arguments, exit_code, &RunPaper);
}

}  // namespace dcloc::cli
