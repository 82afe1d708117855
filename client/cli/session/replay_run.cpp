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

/// Localizes a scan, or takes in a fix; gives what a server would answer.
using Replayer = std::function<absl::StatusOr<v1::LocalizeResponse>(const v1::LocalizeRequest&)>;

struct Comparison {
  std::int64_t scan_count = 0;     ///< recorded
  std::int64_t fix_count = 0;      ///< recorded
  std::int64_t skipped_count = 0;  ///< refused when they were recorded, and so not replayed
  std::int64_t equal_count = 0;
  std::int64_t different_count = 0;
  std::string first_recorded;
  std::string first_replayed;
};

/// What was asked and answered at one place of a recording.
struct Step {
  v1::LocalizeRequest request;
  v1::LocalizeResponse answer;
};

Step StepOf(v1::RecordingEntry entry) {
  Step step;
  if (entry.has_fix()) {
    *step.request.mutable_position_fix() = std::move(*entry.mutable_fix()->mutable_fix());
    *step.answer.mutable_position_fix_answer() = std::move(*entry.mutable_fix()->mutable_answer());
  } else {
    *step.request.mutable_scan() = std::move(*entry.mutable_scan()->mutable_scan());
    step.answer = std::move(*entry.mutable_scan()->mutable_answer());
  }
  return step;
}

/// The localizer has seen the request.
bool WasTaken(const v1::LocalizeResponse& answer) {
  if (!answer.has_position_fix_answer()) return answer.has_result();
  const v1::FixUse use = answer.position_fix_answer().use();
  return use != v1::FIX_USE_INVALID && use != v1::FIX_USE_OVER_LIMIT;
}

/// What the method made of a scan or a fix, without what differs from run to run, and without what
/// recordings of that version have not.
std::string Essence(const v1::LocalizeResponse& answer, int format_version) {
  if (answer.has_position_fix_answer()) return answer.position_fix_answer().SerializeAsString();
  v1::LocalizationResult result = answer.result();
  result.clear_timings();
  result.clear_map_version();
  result.clear_geodetic_pose();
  if (format_version < 2) {
    result.clear_protection_level_m();
    result.clear_health();
    result.clear_resets();
  }
  return result.SerializeAsString();
}

absl::StatusOr<Comparison> Compare(client::RecordingReader& recording, const Replayer& replay) {
  const int version = recording.header().format_version();
  Comparison comparison;
  while (true) {
    auto next = recording.Next();
    if (!next.ok()) return next.status();
    if (!next->has_value()) return comparison;
    const Step step = StepOf(**std::move(next));
    ++(step.request.has_scan() ? comparison.scan_count : comparison.fix_count);
    if (!WasTaken(step.answer)) {
      ++comparison.skipped_count;
      continue;
    }
    const auto replayed = replay(step.request);
    if (!replayed.ok()) return replayed.status();
    if (replayed->message_case() == step.answer.message_case() &&
        Essence(*replayed, version) == Essence(step.answer, version)) {
      ++comparison.equal_count;
    } else if (comparison.different_count++ == 0) {
      comparison.first_recorded = AnswerLine(step.answer);
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

absl::StatusOr<v1::LocalizeResponse> LocalizeHere(const v1::Scan& scan, const Rig& rig,
                                                  Localizer& localizer) {
  v1::LocalizeResponse response;
  const absl::StatusOr<Localization> localization = localizer.Localize(FromProto(scan));
  if (localization.ok()) {
    *response.mutable_result() = ToProto(*localization, rig, scan.sequence_number());
  } else {
    response.mutable_rejected()->set_sequence_number(scan.sequence_number());
    response.mutable_rejected()->set_message(std::string(localization.status().message()));
  }
  return response;
}

absl::StatusOr<v1::LocalizeResponse> TakeFixHere(const v1::PositionFix& message,
                                                 const std::optional<GeodeticAnchor>& anchor,
                                                 Localizer& localizer) {
  const absl::StatusOr<PositionFix> fix = FromProto(message, anchor);
  if (!fix.ok()) return fix.status();
  const absl::StatusOr<FixUse> use = localizer.TakeFix(*fix);
  v1::LocalizeResponse response;
  v1::PositionFixAnswer& answer = *response.mutable_position_fix_answer();
  answer.set_stamp_ns(message.stamp_ns());
  answer.set_use(use.ok() ? ToProto(*use) : v1::FIX_USE_INVALID);
  answer.set_message(std::string(use.status().message()));
  return response;
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
      Localizer::Create(*map, start->rig, start->initial_pose, start->options);
  if (!localizer.ok()) return localizer.status();
  return Compare(recording, [&](const v1::LocalizeRequest& request) {
    return request.has_scan()
               ? LocalizeHere(request.scan(), start->rig, *localizer)
               : TakeFixHere(request.position_fix(), (*map)->info().anchor, *localizer);
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
  return Compare(
      recording, [&](const v1::LocalizeRequest& request) -> absl::StatusOr<v1::LocalizeResponse> {
        absl::Status status = request.has_scan() ? (*session)->Send(request.scan())
                                                 : (*session)->SendFix(request.position_fix());
        if (!status.ok()) return status;
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
                                      {"fix_count", comparison.fix_count},
                                      {"skipped_count", comparison.skipped_count},
                                      {"equal_count", comparison.equal_count},
                                      {"different_count", comparison.different_count}}
                             .dump(2));
    return;
  }
  absl::PrintF(
      "session %s of %s, recorded by %s: %d scans and %d position fixes, %d of them refused then\n",
      Visible(header.opened().session_id()), Visible(header.open().vehicle_id()),
      Visible(header.program()), comparison.scan_count, comparison.fix_count,
      comparison.skipped_count);
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
