#include "client/cli/doctor/doctor_command.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/terminal.h"
#include "client/cli/doctor/finding.h"
#include "client/cli/doctor/rig_checks.h"
#include "client/cli/doctor/server_checks.h"
#include "client/cli/remote/server_options.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

constexpr int kWarned = 3;  // beside those of exit_codes.h: no other command warns

struct DoctorArguments {
  ServerCheckOptions server{.channel = {}, .map = "", .at_map_m = {}, .vehicle = "dcloc-doctor"};
  std::vector<double> at_m;
  DatasetArguments dataset;
  DriveRequest drive;
  bool json = false;
};

absl::StatusOr<Findings> Examine(DoctorArguments arguments) {
  if (!arguments.at_m.empty()) {
    arguments.server.at_map_m = Eigen::Vector2d(arguments.at_m[0], arguments.at_m[1]);
  }
  std::optional<Drive> drive;
  if (!arguments.drive.name.empty()) {
    absl::StatusOr<Drive> read = ReadDrive(arguments.dataset, arguments.drive);
    if (!read.ok()) return read.status();
    if (read->scans.empty()) {
      return absl::InvalidArgumentError(absl::StrFormat("drive %s has no scans", read->name));
    }
    drive = *std::move(read);
  }
  Findings findings;
  if (!arguments.server.channel.server.empty()) {
    findings = CheckServer(arguments.server, drive ? &*drive : nullptr);
  }
  if (drive) {
    for (Finding& finding : CheckRig(*drive)) findings.push_back(std::move(finding));
  }
  return findings;
}

int Run(const DoctorArguments& arguments) {
  const absl::StatusOr<Findings> findings = Examine(arguments);
  if (!findings.ok()) return Fail(findings.status());
  absl::PrintF("%s", arguments.json ? FindingsJson(*findings).dump(
                                          2, ' ', false, ordered_json::error_handler_t::replace) +
                                          "\n"
                                    : FindingsText(*findings));
  switch (WorstOf(*findings)) {
    case CheckResult::kFailed:
      return kFailure;
    case CheckResult::kWarning:
      return kWarned;
    default:
      return kSuccess;
  }
}

void AddServer(CLI::App& doctor, DoctorArguments& arguments) {
  CLI::Option* server = AddServerOptions(doctor, arguments.server.channel)->required(false);
  CLI::Option* map =
      doctor.add_option("--map", arguments.server.map, "Map that is to be driven in")
          ->needs(server)
          ->type_name("NAME");
  doctor.add_option("--at", arguments.at_m, "Place in the map's frame that it must cover [m]")
      ->delimiter(',')
      ->expected(2)
      ->needs(map)
      ->type_name("X,Y");
  CLI::Option* opens =
      doctor
          .add_flag("--open-session", arguments.server.opens_session,
                    "Open a session in the map and send a scan without targets, to compare clocks")
          ->needs(map);
  doctor
      .add_option("--vehicle", arguments.server.vehicle,
                  "As which vehicle; a session that it has at the time ends")
      ->needs(opens)
      ->type_name("NAME")
      ->capture_default_str();
}

}  // namespace

void AddDoctorCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DoctorArguments>();
  CLI::App* doctor = app.add_subcommand(
      "doctor", "Say what is wrong between a vehicle, its data and a server, and what to do");
  AddServer(*doctor, *arguments);
  AddDatasetOptions(*doctor, arguments->dataset);
  CLI::Option* dataset = doctor->get_option("--dataset")->required(false);
  CLI::Option* root = doctor->get_option("--root")->required(false);
  CLI::Option* drive =
      doctor->add_option("--drive", arguments->drive.name, "Drive that the rig is held against")
          ->needs(dataset)
          ->needs(root)
          ->type_name("NAME");
  dataset->needs(drive);
  AddRadarsOption(*doctor, "--radars", arguments->drive.radars, "Its radars; all by default");
  AddDriveRequestOptions(*doctor, arguments->drive);
  doctor->add_flag("--json", arguments->json, "Print as JSON");
  doctor->footer(
      "The exit code is 1 where a check failed, else 3 where one warns, else 0.\n"
      "Examples:\n"
      "  dcloc doctor --server localhost:50051 --map town --at 120,40 --open-session\n"
      "  dcloc doctor --dataset rosbag --root bags --drive monday --json");
  doctor->callback([doctor, arguments, drive, &exit_code] {
    if (doctor->count("--server") == 0 && drive->count() == 0) {
      throw CLI::RequiredError("At least one of --server and --drive");
    }
    exit_code = Run(*arguments);
  });
}

}  // namespace dcloc::cli
