#include "client/cli/dataset/dataset_command.h"

#include <memory>
#include <optional>
#include <string>

#include "client/cli/common/anchor_option.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/terminal.h"
#include "client/cli/common/trajectory_options.h"
#include "client/cli/common/written_file.h"
#include "client/cli/dataset/inspect_run.h"
#include "client/datasets/export_bag.h"

namespace dcloc::cli {
namespace {

struct DatasetCommandArguments {
  DatasetArguments dataset;
  DriveRequest drive;
  TrajectoryArguments trajectory;
  std::optional<GeodeticAnchor> anchor;
  std::string bag_file;
  std::string compression = "lz4";
  bool json = false;
};

absl::Status WriteReference(const DatasetCommandArguments& arguments) {
  absl::Status status = CheckTrajectory(arguments.trajectory, arguments.anchor.has_value());
  if (!status.ok()) return status;
  const absl::StatusOr<Drive> drive = ReadDrive(arguments.dataset, arguments.drive);
  if (!drive.ok()) return drive.status();
  status = CheckHasReference(*drive, "a trajectory");
  if (!status.ok()) return status;
  Trajectory trajectory{.name = drive->name, .anchor = arguments.anchor, .poses = {}};
  for (const DriveScan& entry : drive->scans) {
    trajectory.poses.push_back({entry.scan.stamp, entry.T_map_vehicle});
  }
  SortByStamp(trajectory.poses);
  status = WriteTrajectory(arguments.trajectory, trajectory);
  if (status.ok()) {
    PrintWritten(arguments.trajectory.file, "pose", trajectory.poses.size(), arguments.json);
  }
  return status;
}

absl::Status Export(const DatasetCommandArguments& arguments) {
  const auto compression = rosbag::CompressionByName(arguments.compression);
  if (!compression.ok()) return compression.status();
  const absl::StatusOr<Drive> drive = ReadDrive(arguments.dataset, arguments.drive);
  if (!drive.ok()) return drive.status();
  const absl::Status status = ExportBag(*drive, arguments.bag_file, *compression);
  if (status.ok()) {
    PrintWritten(arguments.bag_file, "scan", drive->scans.size(), arguments.json);
  }
  return status;
}

/// The options that say which drive; those of `dataset` and the name are required.
void AddDriveOptions(CLI::App& command, DatasetArguments& dataset, DriveRequest& drive) {
  AddDatasetOptions(command, dataset);
  command.add_option("--drive", drive.name, "The drive")->required()->type_name("NAME");
  AddRadarsOption(command, "--radars", drive.radars, "Its radars; all by default");
  AddDriveRequestOptions(command, drive);
}

void AddInspect(CLI::App& dataset, int& exit_code) {
  auto arguments = std::make_shared<InspectArguments>();
  CLI::App* inspect = dataset.add_subcommand(
      "inspect", "Say what a data set, a drive or a bag holds, and what its range rates are");
  inspect->add_option("path", arguments->path, "A bag, or the folder of a data set, as --root")
      ->check(CLI::ExistingPath)
      ->type_name("PATH");
  AddDriveOptions(*inspect, arguments->dataset, arguments->drive);
  for (const char* known_by_itself : {"--dataset", "--root", "--drive"}) {
    inspect->get_option(known_by_itself)->required(false);
  }
  inspect
      ->add_option("--write-mapping", arguments->mapping_file,
                   "Of a bag: write the mapping that fits its data, to be put beside the bag as "
                   "dcloc_bag.json")
      ->type_name("FILE");
  inspect->add_flag("--json", arguments->json, "Print as JSON");
  inspect->footer(
      "Without --drive the drives are listed; a single one is inspected.\n"
      "Range rates must be relative to the moving radar and positive for what recedes. Whether "
      "they\n"
      "are, the targets tell, where the vehicle's velocity or its poses are known.\n"
      "Examples:\n"
      "  dcloc dataset inspect monday.bag --write-mapping dcloc_bag.json\n"
      "  dcloc dataset inspect sim\n"
      "  dcloc dataset inspect --dataset nuscenes --root sim --drive live-0 --json");
  inspect->callback([inspect, arguments, &exit_code] {
    if (arguments->path.empty() == arguments->dataset.root.empty()) {
      throw CLI::RequiredError("One of PATH and --root");
    }
    const absl::Status status = RunInspect(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

CLI::App* AddDriveCommand(CLI::App& dataset, const char* name, const char* description,
                          const std::shared_ptr<DatasetCommandArguments>& arguments,
                          absl::Status (*run)(const DatasetCommandArguments&), int& exit_code) {
  CLI::App* command = dataset.add_subcommand(name, description);
  AddDriveOptions(*command, arguments->dataset, arguments->drive);
  command->add_flag("--json", arguments->json, "Print as JSON");
  OnRun(*command, arguments, exit_code, run);
  return command;
}

void AddTrajectory(CLI::App& dataset, int& exit_code) {
  auto arguments = std::make_shared<DatasetCommandArguments>();
  CLI::App* trajectory = AddDriveCommand(dataset, "trajectory", "Write a drive's reference poses",
                                         arguments, &WriteReference, exit_code);
  AddTrajectoryOptions(*trajectory, arguments->trajectory)->required();
  AddAnchorOption(*trajectory, arguments->anchor);
  trajectory->footer(
      "Example:\n  dcloc dataset trajectory --dataset nuscenes --root sim --drive live-0 \\\n"
      "      --trajectory-out truth.tum");
}

void AddExport(CLI::App& dataset, int& exit_code) {
  auto arguments = std::make_shared<DatasetCommandArguments>();
  CLI::App* command = AddDriveCommand(dataset, "export", "Write a drive as a bag of ROS 1",
                                      arguments, &Export, exit_code);
  command->add_option("--bag", arguments->bag_file, "The bag; an older one is replaced")
      ->required()
      ->type_name("FILE");
  command->add_option("--compression", arguments->compression, "How its chunks are packed")
      ->check(CLI::IsMember({"none", "bz2", "lz4"}))
      ->capture_default_str();
  command->footer(
      "--dataset rosbag reads the same drive from it, to the bit. How the radars measure is "
      "written\n"
      "to dcloc_rig.json beside it.\n"
      "Example:\n  dcloc dataset export --dataset nuscenes --root sim --drive live-0 \\\n"
      "      --bag bags/live-0.bag");
}

}  // namespace

void AddDatasetCommand(CLI::App& app, int& exit_code) {
  CLI::App* dataset = app.add_subcommand("dataset", "See and convert recorded drives");
  dataset->require_subcommand(1);
  AddInspect(*dataset, exit_code);
  AddTrajectory(*dataset, exit_code);
  AddExport(*dataset, exit_code);
}

}  // namespace dcloc::cli
