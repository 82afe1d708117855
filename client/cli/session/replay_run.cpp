#include "client/cli/session/replay_run.h"
#include "client/cli/common/terminal.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/wire.h"
#include "client/cli/session/wire_session.h"
#include "client/sdk/recording.h"
#include "client/sdk/session.h"
#include "client/sdk/sha256.h"
#include "core/map/radar_map.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

/// Localizes a scan; gives what a server would answer.
using Replayer = std::function<absl::StatusOr<v1::LocalizeResponse>(const v1::Scan&)>;

struct Comparison {
  std::int64_t scan_count = 0;     ///< recorded
  std::int64_t skipped_count = 0;  ///< refused when they were recorded, and so not replayed
  std::int64_t equal_count = 0;
  std::int64_t different_count = 0;
  std::string first_recorded;
  std::string first_replayed;
};

/// What the method made of a scan, without what differs from run to run.
std::string Essence(const v1::LocalizeResponse& answer) {
  v1::LocalizationResult result = answer.result();
  result.clear_timings();
  result.clear_map_version();
  result.clear_geodetic_pose();
  return result.SerializeAsString();
}

absl::StatusOr<Comparison> Compare(client::RecordingReader& recording, const Replayer& replay) {
  Comparison comparison;
  while (true) {
    const auto next = recording.Next();
    if (!next.ok()) return next.status();
    if (!next->has_value()) return comparison;
    const v1::RecordedScan& recorded = **next;
    ++comparison.scan_count;
    if (!recorded.answer().has_result()) {
      ++comparison.skipped_count;
      continue;
    }
    const auto replayed = replay(recorded.scan());
    if (!replayed.ok()) return replayed.status();
    if (replayed->has_result() && Essence(*replayed) == Essence(recorded.answer())) {
      ++comparison.equal_count;
    } else if (comparison.different_count++ == 0) {
      comparison.first_recorded = AnswerLine(recorded.answer());
      comparison.first_replayed = AnswerLine(*replayed);
    }
  }
}

absl::Status CheckMapHash(const ReplayArguments& arguments, const v1::RecordingHeader& header) {
  if (arguments.any_map || header.map_sha256().empty()) return absl::OkStatus();
  const absl::StatusOr<std::string> sha256 = client::Sha256OfFile(arguments.map_file);
  if (!sha256.ok()) return sha256.status();
  if (*sha256 == header.map_sha256()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(arguments.map_file, ": is not the map of the recording (",
                   header.opened().map_name(), " version ", header.opened().map_version(),
                   ", SHA-256 ", header.map_sha256(), "); --any-map replays in it all the same"));
}

absl::StatusOr<Comparison> ReplayHere(const ReplayArguments& arguments,
                                      client::RecordingReader& recording) {
  if (absl::Status status = CheckMapHash(arguments, recording.header()); !status.ok()) {
    return status;
  }
  const auto map = RadarMap::Open(arguments.map_file);
  if (!map.ok()) return map.status();
  absl::StatusOr<SessionStart> start = FromProto(recording.header().open(), (*map)->info().anchor);
  if (!start.ok()) return start.status();
  absl::StatusOr<Localizer> localizer =
      Localizer::Create(*map, std::move(start->rig), start->initial_pose, start->options);
  if (!localizer.ok()) return localizer.status();
  return Compare(recording, [&](const v1::Scan& scan) -> absl::StatusOr<v1::LocalizeResponse> {
    v1::LocalizeResponse response;
    const absl::StatusOr<Localization> localization = localizer->Localize(FromProto(scan));
    if (localization.ok()) {
      *response.mutable_result() = ToProto(*localization, scan.sequence_number());
    } else {
      response.mutable_rejected()->set_sequence_number(scan.sequence_number());
      response.mutable_rejected()->set_message(std::string(localization.status().message()));
    }
    return response;
  });
}

absl::StatusOr<Comparison> ReplayAtServer(const ReplayArguments& arguments,
                                          client::RecordingReader& recording) {
  v1::OpenSession open = recording.header().open();
  open.set_vehicle_id(recording.header().open().vehicle_id());
  open.set_map_version(arguments.any_map ? 0 : recording.header().opened().map_version());
  const auto channel = client::MakeChannel(arguments.server);
  if (!channel.ok()) return channel.status();
  // A session that begins anew would not be the recorded one.
  const auto session = client::Session::Open(
      *channel, open, {.when_full = client::FullQueue::kBlock, .reconnect = std::nullopt});
  if (!session.ok()) {
    return absl::Status(session.status().code(),
                        absl::StrCat(arguments.server.server, ": ", session.status().message()));
  }
  return Compare(recording, [&](const v1::Scan& scan) -> absl::StatusOr<v1::LocalizeResponse> {
    if (absl::Status status = (*session)->Send(scan); !status.ok()) return status;
    std::optional<v1::LocalizeResponse> answer = (*session)->Next();
    if (!answer) return (*session)->EndStatus();
    return *std::move(answer);
  });
}

void Print(const ReplayArguments& arguments, const v1::RecordingHeader& header,
           const std::string& end_reason, const Comparison& comparison) {
  if (arguments.json) {
    absl::PrintF("%s\n", ordered_json{{"session_id", header.opened().session_id()},
                                      {"vehicle_id", header.open().vehicle_id()},
                                      {"program", header.program()},
                                      {"end_reason", end_reason},
                                      {"scan_count", comparison.scan_count},
                                      {"skipped_count", comparison.skipped_count},
                                      {"equal_count", comparison.equal_count},
                                      {"different_count", comparison.different_count}}
                             .dump(2));
    return;
  }
  absl::PrintF("session %s of %s, recorded by %s: %d scans, %d of them refused then\n",
               Visible(header.opened().session_id()), Visible(header.open().vehicle_id()),
               Visible(header.program()), comparison.scan_count, comparison.skipped_count);
  absl::PrintF("%d answers are the same to the bit, %d differ\n", comparison.equal_count,
               comparison.different_count);
}

}  // namespace

absl::Status RunReplay(const ReplayArguments& arguments) {
  absl::StatusOr<client::RecordingReader> recording = client::RecordingReader::Open(arguments.file);
  if (!recording.ok()) return recording.status();
  const absl::StatusOr<Comparison> comparison = arguments.map_file.empty()
                                                    ? ReplayAtServer(arguments, *recording)
                                                    : ReplayHere(arguments, *recording);
  if (!comparison.ok()) return comparison.status();
  Print(arguments, recording->header(), recording->end_reason(), *comparison);
  if (comparison->different_count == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(comparison->different_count, " answers differ, the first\nrecorded: ",
                   comparison->first_recorded, "\nreplayed: ", comparison->first_replayed));
}

}  // namespace dcloc::cli
