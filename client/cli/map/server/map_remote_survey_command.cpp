#include "client/cli/map/server/map_remote_survey_command.h"

#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/common/progress.h"
#include "client/cli/map/server/map_call.h"
#include "client/cli/map/server/remote_builds.h"
#include "client/cli/remote/wire.h"

namespace dcloc::cli {
namespace {

/// The messages of all drives, one after the other; drives are read one at a time.
class DriveMessages {
 public:
  explicit DriveMessages(const MapArguments& arguments) : arguments_(arguments) {}

  /// False after the last one; errors of reading a drive.
  absl::StatusOr<bool> Next(v1::StartMapBuildRequest* message) {
    if (drive_ && sent_ == drive_->scans.size()) drive_.reset();
    if (!drive_) return BeginDrive(message);
    *message->mutable_scan()->mutable_scan() =
        ToProto(drive_->scans[sent_].scan, static_cast<std::int64_t>(sent_));
    progress_->Update(++sent_);
    return true;
  }

 private:
  absl::StatusOr<bool> BeginDrive(v1::StartMapBuildRequest* message) {
    if (next_drive_ == arguments_.drives.size()) return false;
    DriveRequest request = arguments_.drive;
    request.name = arguments_.drives[next_drive_++];
    absl::StatusOr<Drive> drive = ReadDrive(arguments_.dataset, request);
    if (!drive.ok()) return drive.status();
    if (absl::Status status = CheckRadarsOfScans(*drive); !status.ok()) return status;
    drive_ = *std::move(drive);
    sent_ = 0;
    progress_.emplace(absl::StrCat("sending scans of ", drive_->name), drive_->scans.size());
    message->mutable_drive()->set_name(drive_->name);
    *message->mutable_drive()->mutable_rig() = ToProto(drive_->rig);
    return true;
  }

  const MapArguments& arguments_;
  std::size_t next_drive_ = 0;
  std::optional<Drive> drive_;
  std::size_t sent_ = 0;
  std::optional<Progress> progress_;
};

absl::Status RemoteSurvey(client::MapClient& maps, const MapArguments& arguments) {
  v1::MapBuildHeader header;
  header.set_map_name(arguments.map);
  header.set_activate(arguments.activate);
  DriveMessages messages(arguments);
  const absl::StatusOr<v1::MapBuild> started = maps.StartSurvey(
      header, [&](v1::StartMapBuildRequest* message) { return messages.Next(message); });
  if (!started.ok()) return started.status();
  return arguments.no_wait ? PrintBuild(*started, arguments.json)
                           : FollowBuild(maps, *started, arguments.json);
}

}  // namespace

void AddMapRemoteSurveyCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<MapArguments>();
  CLI::App* app = AddMapCall(map_command, "remote-survey",
                             "Have a server make a version of drives whose poses are not known",
                             &RemoteSurvey, arguments, exit_code);
  AddDatasetOptions(*app, arguments->dataset);
  app->add_option("--drive", arguments->drives, "Drives to survey: scenes or sequences")
      ->required()
      ->delimiter(',')
      ->type_name("NAME,...");
  AddRadarsOption(*app, "--radars", arguments->drive.radars,
                  "Radars to survey with; all by default");
  AddDriveRequestOptions(*app, arguments->drive);
  AddMapName(*app, *arguments, "Map that gets the version; made if it is new")->required();
  app->add_flag("--activate", arguments->activate, "New sessions get this version once it is made");
  app->add_flag("--no-wait", arguments->no_wait,
                "Do not wait for the build once the scans are there");
  AddJson(*app, *arguments);
  app->footer(
      "Ctrl-C while it waits cancels the build.\n"
      "Example:\n"
      "  dcloc map remote-survey --server localhost:50051 --map town --activate \\\n"
      "      --dataset nuscenes --root sim --drive map,live-0,live-1");
}

}  // namespace dcloc::cli
