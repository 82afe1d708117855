#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/cli/calibrate/calibrate_command.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/json_folder.h"
#include "client/cli/common/terminal.h"
#include "client/cli/dataset/dataset_command.h"
#include "client/cli/describe/describe_command.h"
#include "client/cli/doctor/doctor_command.h"
#include "client/cli/evaluate/evaluate_command.h"
#include "client/cli/load/load_command.h"
#include "client/cli/localize/localize_command.h"
#include "client/cli/map/map_command.h"
#include "client/cli/map/server/map_server_command.h"
#include "client/cli/plot/plot_command.h"
#include "client/cli/server/server_command.h"
#include "client/cli/session/session_command.h"
#include "client/cli/session/session_propose_command.h"
#include "client/cli/session/session_record_command.h"
#include "client/cli/simulate/simulate_command.h"
#include "client/evaluation/baselines/pcl_registration.h"

namespace {

/// The version, and the build: a hash of this very program, and what it was made with.
std::string VersionText() {
  return absl::StrCat("dcloc " DCLOC_VERSION "\nbuild ", dcloc::cli::ProgramHash(),
                      ", " DCLOC_BUILD);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace dcloc::cli;  // NOLINT(google-build-using-namespace): main is its front end
  dcloc::SilencePcl();
  int exit_code = kSuccess;
  try {
    CLI::App app("Radar localization: make maps, localize in them, simulate, evaluate", "dcloc");
    app.set_version_flag("--version", VersionText);
    app.require_subcommand(1);
    app.footer("Each command has its own --help, with an example.");
    AddMapCommand(app, exit_code);
    AddMapServerCommands(*app.get_subcommand("map"), exit_code);
    AddLocalizeCommand(app, exit_code);
    AddLoadCommand(app, exit_code);
    CLI::App* session = AddSessionCommand(app, exit_code);
    AddSessionProposeCommand(*session, exit_code);
    AddSessionRecordCommands(*session, exit_code);
    AddServerCommand(app, exit_code);
    AddCalibrateCommand(app, exit_code);
    AddDatasetCommand(app, exit_code);
    AddDoctorCommand(app, exit_code);
    AddEvaluateCommand(app, exit_code);
    AddPlotCommand(app, exit_code);
    AddSimulateCommand(app, exit_code);
    AddDescribeCommands(app, DCLOC_VERSION, exit_code);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? kSuccess : kUsage;
    }
  } catch (const std::exception& error) {
    return Fail(absl::InternalError(error.what()));
  }
  return exit_code;
}
