#include "client/cli/common/dataset_options.h"

#include "absl/strings/str_format.h"
#include "client/cli/common/terminal.h"

namespace dcloc::cli {

void AddDatasetOptions(CLI::App& command, DatasetArguments& arguments) {
  std::vector<std::string> names;
  names.reserve(kDatasetFormatNames.size());
  for (const auto& [name, format] : kDatasetFormatNames) names.emplace_back(name);
  command.add_option("--dataset", arguments.format, "Layout of the data set")
      ->required()
      ->check(CLI::IsMember(names));
  command.add_option("--root", arguments.root, "Folder of the data set")
      ->required()
      ->check(CLI::ExistingDirectory)
      ->type_name("DIR");
  command
      .add_option("--version", arguments.version,
                  "Tables to read (v1.0-mini, ...) where --root holds several")
      ->type_name("NAME");
}

absl::StatusOr<Drive> ReadDrive(const DatasetArguments& arguments, const DriveRequest& request) {
  const absl::StatusOr<DatasetFormat> format = DatasetFormatByName(arguments.format);
  if (!format.ok()) return format.status();
  absl::StatusOr<Drive> drive =
      ReadDrive(Dataset{*format, arguments.root, arguments.version}, request);
  if (!drive.ok()) return drive;
  for (const std::string& note : drive->notes) {
    absl::FPrintF(stderr, "%s: %s\n", Visible(drive->name), Visible(note));
  }
  return drive;
}

void AddDriveRequestOptions(CLI::App& command, DriveRequest& request) {
  command
      .add_option("--rig", request.rig_file,
                  "What is better known of the radars, as `dcloc calibrate` writes it")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command
      .add_option("--beta-s", request.beta_s,
                  "Range-Doppler coupling of all radars, in place of their own")
      ->type_name("S");
  command.add_option("--from-s", request.begin_s, "Begin this long after the drive's first scan")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
  command.add_option("--to-s", request.end_s, "End this long after the drive's first scan")
      ->check(CLI::NonNegativeNumber)
      ->type_name("S");
}

void AddRadarsOption(CLI::App& command, const std::string& name, std::vector<std::string>& radars,
                     const std::string& description) {
  command.add_option(name, radars, description)->delimiter(',')->type_name("A,B");
}

}  // namespace dcloc::cli
