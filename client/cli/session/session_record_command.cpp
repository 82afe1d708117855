#include "client/cli/session/session_record_command.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/live_line.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/common/terminal.h"
#include "client/cli/common/trajectory_options.h"
#include "client/cli/common/written_file.h"
#include "client/cli/remote/admin_run.h"
#include "client/cli/remote/server_options.h"
#include "client/cli/session/recorded_trajectory.h"
#include "client/cli/session/replay_run.h"
#include "client/sdk/recording.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct RecordArguments {
  client::ChannelOptions server;
  std::string vehicle;
  std::string out;
  TrajectoryArguments trajectory;
  bool json = false;
};

void PrintRecorded(const RecordArguments& arguments, const v1::RecordingHeader& header,
                   std::int64_t scan_count, const std::string& reason) {
  if (arguments.json) {
    absl::PrintF("%s\n", ordered_json{{"file", arguments.out},
                                      {"session_id", header.opened().session_id()},
                                      {"vehicle_id", header.open().vehicle_id()},
                                      {"map", header.opened().map_name()},
                                      {"map_version", header.opened().map_version()},
                                      {"scan_count", scan_count},
                                      {"end_reason", reason}}
                             .dump(2));
  } else {
    absl::PrintF("session %s of %s: %d scans in %s; ended: %s\n",
                 Visible(header.opened().session_id()), Visible(header.open().vehicle_id()),
                 scan_count, arguments.out, reason);
  }
}

// The file of a recording that arrives message by message.
class ArrivingRecording {
 public:
  ArrivingRecording(const RecordArguments& arguments, std::stop_source& stop)
      : arguments_(arguments), stop_(stop) {}

  void Take(const v1::RecordSessionResponse& message) {
    if (message.has_header()) return Begin(message.header());
    if (!writer_) return;
    if (message.has_fix()) return writer_->Add(message.fix());
    writer_->Add(message.scan());
    line_.Show(
        absl::StrCat("recording ", arguments_.vehicle, ": ", writer_->scan_count(), " scans"));
  }

  // Closes the file of a stream that ended with `end`. A recording that misses something is left
  // without its end, and so counts as cut off.
  absl::Status Finish(const absl::Status& end) {
    if (!file_status_.ok()) return file_status_;
    if (!end.ok()) return end;
    if (!writer_) {
      return absl::CancelledError(absl::StrCat("stopped before ", arguments_.vehicle,
                                               " opened a session; nothing recorded"));
    }
    const std::string reason =
        stop_.stop_requested() ? "the recording was stopped" : "the session has ended";
    const std::int64_t scan_count = writer_->scan_count();
    absl::Status status = writer_->Close(reason);
    if (status.ok()) PrintRecorded(arguments_, header_, scan_count, reason);
    return status;
  }

 private:
  void Begin(const v1::RecordingHeader& header) {
    header_ = header;
    absl::StatusOr<client::RecordingWriter> created =
        client::RecordingWriter::Create(arguments_.out, header);
    file_status_ = created.status();
    if (created.ok()) {
      writer_.emplace(*std::move(created));
    } else {
      stop_.request_stop();
    }
  }

  const RecordArguments& arguments_;
  std::stop_source& stop_;
  LiveLine line_;
  std::optional<client::RecordingWriter> writer_;
  v1::RecordingHeader header_;
  absl::Status file_status_;
};

absl::Status Record(client::AdminClient& admin, const RecordArguments& arguments,
                    const StopSignals& signals) {
  if (absl::Status status = CheckTrajectory(arguments.trajectory, true); !status.ok()) {
    return status;
  }
  std::stop_source stop;
  const std::jthread watcher = signals.Watch([&stop](int) { stop.request_stop(); });
  ArrivingRecording recording(arguments, stop);
  // Also for scripts, which may let the vehicle come now.
  const auto wait = [&] {
    absl::FPrintF(stderr, "waiting for the next session of %s\n", arguments.vehicle);
  };
  const absl::Status end = admin.RecordSession(
      arguments.vehicle, stop.get_token(), wait,
      [&](const v1::RecordSessionResponse& message) { recording.Take(message); });
  absl::Status status = recording.Finish(end);
  if (status.ok() && !arguments.trajectory.file.empty()) {
    status = WriteRecordedTrajectory(arguments.out, arguments.trajectory).status();
  }
  return status;
}

void AddRecord(CLI::App& session_command, int& exit_code) {
  auto arguments = std::make_shared<RecordArguments>();
  CLI::App* record = session_command.add_subcommand(
      "record", "Record a vehicle's next session, from its opening to its end or Ctrl-C");
  AddServerOptions(*record, arguments->server);
  record->add_option("--vehicle", arguments->vehicle, "Whose next session")
      ->required()
      ->type_name("NAME");
  record->add_option("--out", arguments->out, "The recording; an older one is replaced")
      ->required()
      ->type_name("FILE");
  AddTrajectoryOptions(*record, arguments->trajectory);
  record->add_flag("--json", arguments->json, "Print as JSON");
  record->footer(
      "Scans, position fixes and answers of the whole session: what is needed to localize it "
      "again, bit by bit.\n"
      "A session that is open is not recorded, as its past is not known any more.\n"
      "Example:\n  dcloc session record --server localhost:50051 --vehicle car-17 --out car.rec");
  record->callback([arguments, &exit_code] {
    const StopSignals signals;  // before gRPC has threads
    const absl::Status status = WithAdminClient(arguments->server, [&](client::AdminClient& admin) {
      return Record(admin, *arguments, signals);
    });
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

void AddReplay(CLI::App& session_command, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* replay = session_command.add_subcommand(
      "replay", "Localize a recorded session again, and compare the answers bit by bit");
  replay->add_option("file", arguments->file, "The recording")->required()->type_name("FILE");
  CLI::Option* map =
      replay->add_option("--map", arguments->map_file, "Localize here, in this map file")
          ->type_name("FILE");
  AddServerOptions(*replay, arguments->server)->required(false)->excludes(map);
  replay->add_flag("--any-map", arguments->any_map,
                   "Also in another version of the map than the recorded one");
  replay->add_flag("--json", arguments->json, "Print as JSON");
  replay->footer(
      "With --server, in the map that the recording names. The exit code is 1 when an answer\n"
      "differs in a single bit of state, pose, covariance, quality or health.\n"
      "Examples:\n"
      "  dcloc session replay car.rec --map town.dclm\n"
      "  dcloc session replay car.rec --server localhost:50051");
  replay->callback([arguments, &exit_code] {
    if (arguments->map_file.empty() == arguments->server.server.empty()) {
      throw CLI::RequiredError("Exactly one of --map and --server");
    }
    const absl::Status status = RunReplay(*arguments);
    exit_code = status.ok() ? kSuccess : Fail(status);
  });
}

void AddTrajectory(CLI::App& session_command, int& exit_code) {
  struct Arguments {
    std::string file;
    TrajectoryArguments trajectory;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* trajectory = session_command.add_subcommand(
      "trajectory", "Write the poses that were answered in a recorded session");
  trajectory->add_option("file", arguments->file, "The recording")->required()->type_name("FILE");
  AddTrajectoryOptions(*trajectory, arguments->trajectory)->required();
  trajectory->add_flag("--json", arguments->json, "Print as JSON");
  trajectory->footer("Example:\n  dcloc session trajectory car.rec --trajectory-out car.gpx");
  trajectory->callback([arguments, &exit_code] {
    const std::string& out = arguments->trajectory.file;
    const absl::StatusOr<std::size_t> count =
        WriteRecordedTrajectory(arguments->file, arguments->trajectory);
    exit_code = count.ok() ? kSuccess : Fail(count.status());
    if (count.ok()) PrintWritten(out, "pose", *count, arguments->json);
  });
}

}  // namespace

void AddSessionRecordCommands(CLI::App& session_command, int& exit_code) {
  AddRecord(session_command, exit_code);
  AddReplay(session_command, exit_code);
  AddTrajectory(session_command, exit_code);
}

}  // namespace dcloc::cli
