#include "client/cli/calibrate/calibrate_command.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/calibration_option.h"
#include "client/cli/common/calibration_report.h"
#include "client/cli/common/dataset_options.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/progress.h"
#include "client/datasets/drive_calibration.h"

namespace dcloc::cli {
namespace {

struct CalibrateArguments {
  DatasetArguments dataset;
  DriveRequest drive;  // all but its name
  std::vector<std::string> drives;
  KeptParameters keep;
  std::string out;
  bool json = false;
};

absl::Status CheckSameRadars(const Rig& rig, const Drive& drive) {
  bool same = drive.rig.radars.size() == rig.radars.size();
  for (const RadarModel& radar : drive.rig.radars) same = same && rig.Find(radar.id) != nullptr;
  if (same) return absl::OkStatus();
  const auto id = [](std::string* out, const RadarModel& radar) { out->append(radar.id); };
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s has the radars %s, the drives before it %s: choose by --radars which are "
      "calibrated",
      drive.name, absl::StrJoin(drive.rig.radars, ", ", id), absl::StrJoin(rig.radars, ", ", id)));
}

absl::StatusOr<Calibrator> ReadDrives(const CalibrateArguments& arguments) {
  std::optional<Calibrator> calibrator;
  Rig rig;
  DriveRequest request = arguments.drive;
  for (const std::string& name : arguments.drives) {
    request.name = name;
    const auto drive = ReadDrive(arguments.dataset, request);
    if (!drive.ok()) return drive.status();
    if (!calibrator) {
      rig = drive->rig;
      auto created = Calibrator::Create(rig, OptionsOf(arguments.keep));
      if (!created.ok()) return created.status();
      calibrator = *std::move(created);
    }
    absl::Status status = CheckSameRadars(rig, *drive);
    if (status.ok()) {
      Progress progress(absl::StrCat("reading ", name), drive->scans.size());
      status = AddDrive(*drive, *calibrator, [&](std::size_t done) { progress.Update(done); });
    }
    if (!status.ok()) return status;
  }
  return *std::move(calibrator);
}

absl::Status Calibrate(const CalibrateArguments& arguments) {
  const auto calibrator = ReadDrives(arguments);
  if (!calibrator.ok()) return calibrator.status();
  std::optional<Progress> progress;
  const auto calibration = calibrator->Estimate([&](std::size_t done, std::size_t total) {
    if (!progress) progress.emplace("estimating", total);
    progress->Update(done);
  });
  progress.reset();
  if (!calibration.ok()) return calibration.status();
  if (!arguments.out.empty()) {
    const std::string text = RigFileJson(calibration->radars).dump(2) + "\n";
    absl::Status status =
        WriteFileAtomically(arguments.out, std::as_bytes(std::span<const char>(text)));
    if (!status.ok()) return status;
  }
  absl::PrintF("%s", arguments.json ? CalibrationJson(*calibration).dump(2) + "\n"
                                    : CalibrationText(*calibration));
  return absl::OkStatus();
}

}  // namespace

void AddCalibrateCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* calibrate = app.add_subcommand(
      "calibrate", "Estimate what is wrong with the description of a vehicle's radars");
  AddDatasetOptions(*calibrate, arguments->dataset);
  calibrate
      ->add_option("--drive", arguments->drives,
                   "Drives of one vehicle, with reference poses. Several passes of one place at "
                   "different speeds tell most of beta")
      ->required()
      ->delimiter(',')
      ->type_name("A,B");
  AddRadarsOption(*calibrate, "--radars", arguments->drive.radars,
                  "Radars to calibrate, together; all by default");
  AddDriveRequestOptions(*calibrate, arguments->drive);
  AddKeepOption(*calibrate, arguments->keep);
  calibrate->add_option("--out", arguments->out, "Write a rig file, which --rig takes")
      ->type_name("FILE");
  calibrate->add_flag("--json", arguments->json, "Print as JSON");
  calibrate->footer(
      "Estimated together for each radar: the range-Doppler coupling beta, the time by which it\n"
      "measures later than its stamps, a range bias and a yaw of the mount. They mimic one another "
      "where\nall passes are alike; what is then kept (--keep) must be known from elsewhere.\n"
      "Of each, what all radars have in common and what is each one's own are applied if that\n"
      "promises smaller errors than the description has.\n"
      "Examples:\n"
      "  dcloc calibrate --dataset nuscenes --root ~/nuscenes --drive scene-0061,scene-1094 \\\n"
      "      --out car.json\n"
      "  dcloc map build --dataset nuscenes --root ~/nuscenes --drive scene-0796 --rig car.json "
      "\\\n"
      "      --out scene-0796.dclm");
  OnRun(*calibrate, arguments, exit_code, &Calibrate);
}

}  // namespace dcloc::cli
