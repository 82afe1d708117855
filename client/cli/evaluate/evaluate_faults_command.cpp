#include "client/cli/evaluate/evaluate_faults_command.h"

#include <memory>

#include "client/cli/common/on_run.h"
#include "client/cli/evaluate/evaluate_faults_run.h"

namespace dcloc::cli {

void AddEvaluateFaultsCommand(CLI::App& evaluate, int& exit_code) {
  auto arguments = std::make_shared<FaultArguments>();
  CLI::App* faults = evaluate.add_subcommand(
      "faults", "Let velocities, clocks, radars, priors and traffic lie, and judge every answer");
  faults->add_option("--out", arguments->folder, "Folder for the report; made where it is missing")
      ->required()
      ->type_name("DIR");
  faults->add_option("--seed", arguments->seed, "Makes other worlds and drives")
      ->check(CLI::Range(0, 1'000'000))
      ->type_name("N")
      ->capture_default_str();
  faults
      ->add_option("--only", arguments->only,
                   "Faults, families of faults, or worlds: nothing else is tried")
      ->delimiter(',')
      ->type_name("FAULT_OR_WORLD");
  faults->add_option("--jobs", arguments->jobs, "Worlds at a time")
      ->check(CLI::Range(1, 256))
      ->type_name("N")
      ->capture_default_str();
  faults->add_flag("--quick", arguments->quick, "A few faults in a town: does everything work?");
  faults->add_flag("--json", arguments->json, "Print as JSON");
  faults->footer(
      "Writes report.html and results.json. Finished sessions are kept in runs/: what was "
      "interrupted\ngoes on there when it is started again by the same program.\n"
      "Example:\n  dcloc evaluate faults --out faults --only velocity,tunnel --jobs 4");
  // `evaluate` asks for its options only where it is to evaluate drives itself.
  faults->preparse_callback([&evaluate](std::size_t) {
    for (CLI::Option* option : evaluate.get_options()) option->required(false);
  });
  OnRun(*faults, arguments, exit_code, &RunFaults);
}

}  // namespace dcloc::cli
