#include "client/cli/map/server/remote_builds.h"

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/calibration_report.h"
#include "client/cli/common/stage_line.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/server/map_call.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/wire.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollInterval(200);
/// For a server that is restarted, or that another one takes over from.
constexpr std::chrono::seconds kPatience(30);

ordered_json DriveJson(const v1::MapBuildDriveResult& drive) {
  return {{"name", drive.name()},
          {"is_in_map", drive.in_map()},
          {"reason", drive.reason()},
          {"length_m", drive.length_m()}};
}

std::vector<RadarCalibration> RadarsOf(const v1::MapBuild& build) {
  std::vector<RadarCalibration> radars;
  for (const v1::SurveyedRadar& radar : build.radars()) radars.push_back(FromProto(radar));
  return radars;
}

void Show(const v1::MapBuild& build, StageLine& line) {
  line.Update(build.stage().empty() ? "the build waits for its turn"
                                    : absl::StrCat("the server: ", build.stage()),
              build.stage_share());
}

/// Until it has ended, or `signal_count` says to wait no more.
absl::StatusOr<v1::MapBuild> WaitFor(client::MapClient& maps, v1::MapBuild build,
                                     const std::atomic<int>& signal_count) {
  StageLine line;
  Clock::time_point answered = Clock::now();
  while (build.state() == v1::MAP_BUILD_STATE_RUNNING && signal_count < 2) {
    Show(build, line);
    std::this_thread::sleep_for(kPollInterval);
    absl::StatusOr<v1::MapBuild> now = maps.GetBuild(build.build_id());
    if (now.ok()) {
      answered = Clock::now();
      build = *std::move(now);
    } else if (!absl::IsUnavailable(now.status()) || Clock::now() - answered >= kPatience) {
      return now.status();
    }
  }
  return build;
}

void SayWhatIsLeftOut(const v1::MapBuild& build) {
  for (const v1::MapBuildDriveResult& drive : build.drives()) {
    if (drive.reason().empty()) continue;
    absl::FPrintF(stderr, "%s%s: %s\n", drive.in_map() ? "" : "left out: ", Visible(drive.name()),
                  Visible(drive.reason()));
  }
}

const char* MethodText(v1::MapBuildMethod method) {
  switch (method) {
    case v1::MAP_BUILD_METHOD_SURVEY:
      return "survey";
    case v1::MAP_BUILD_METHOD_UPDATE:
      return "update";
    default:
      return "known poses";
  }
}

ordered_json UpdateJson(const v1::MapUpdateResult& update) {
  return {
      {"base_version", update.base_version()},
      {"came_count", update.added_count()},
      {"went_count", update.removed_count()},
      {"kept_count", update.kept_count()},
      {"judged_by", update.judged_by()},
      {"is_better", update.is_better()},
      {"reason", update.reason()},
      {"old", {{"error_m", update.old_error_m()}, {"tracking_share", update.old_tracking_share()}}},
      {"new",
       {{"error_m", update.new_error_m()}, {"tracking_share", update.new_tracking_share()}}}};
}

void SayWhatWasFoundOfRadars(const v1::MapBuild& build) {
  if (build.radars_size() == 0) return;
  std::vector<RadarCalibration> radars = RadarsOf(build);
  for (RadarCalibration& radar : radars) radar.described.id = Visible(radar.described.id);
  absl::FPrintF(stderr, "radars against their description, with 95 %% intervals; * is taken\n%s",
                FormatTable(RadarCalibrationRows(radars)));
}

void SayWhatHasChanged(const v1::MapBuild& build) {
  if (!build.has_update()) return;
  const v1::MapUpdateResult& update = build.update();
  absl::FPrintF(stderr,
                "version %d: %d landmarks came, %d went, %d stayed\n"
                "%s: median error %.3f m, before %.3f m; tracks %.1f %%, before %.1f %%\n",
                update.base_version(), update.added_count(), update.removed_count(),
                update.kept_count(), Visible(update.judged_by()), update.new_error_m(),
                update.old_error_m(), 100.0 * update.new_tracking_share(),
                100.0 * update.old_tracking_share());
}

absl::Status PrintVersion(const v1::MapBuild& build, bool json) {
  if (!json) {
    absl::PrintF("%s\n", Text(build.version()));
    return absl::OkStatus();
  }
  ordered_json version = Json(build.version());
  if (build.drives_size() > 0) version["drives"] = BuildJson(build)["drives"];
  if (build.radars_size() > 0) version["radars"] = RadarCalibrationsJson(RadarsOf(build));
  if (build.has_update()) version["update"] = UpdateJson(build.update());
  absl::PrintF("%s\n", version.dump(2));
  return absl::OkStatus();
}

}  // namespace

const char* StateText(const v1::MapBuild& build) {
  switch (build.state()) {
    case v1::MAP_BUILD_STATE_RUNNING:
      return "running";
    case v1::MAP_BUILD_STATE_DONE:
      return "done";
    case v1::MAP_BUILD_STATE_FAILED:
      return "failed";
    case v1::MAP_BUILD_STATE_CANCELLED:
      return "cancelled";
    default:
      return "unknown";
  }
}

ordered_json BuildJson(const v1::MapBuild& build) {
  ordered_json json = {{"build", build.build_id()},
                       {"map", build.map_name()},
                       {"method", MethodText(build.method())},
                       {"state", StateText(build)},
                       {"stage", build.stage()},
                       {"stage_share", build.stage_share()},
                       {"scan_count", build.scan_count()},
                       {"done_scan_count", build.done_scan_count()},
                       {"attempt_count", build.attempt_count()},
                       {"create_time", TimeText(build.create_time())},
                       {"version", build.version().version()},
                       {"error", build.error_message()}};
  if (build.drives_size() > 0) json["drives"] = ordered_json::array();
  for (const v1::MapBuildDriveResult& drive : build.drives()) {
    json["drives"].push_back(DriveJson(drive));
  }
  if (build.radars_size() > 0) json["radars"] = RadarCalibrationsJson(RadarsOf(build));
  if (build.has_update()) json["update"] = UpdateJson(build.update());
  return json;
}

absl::Status PrintBuild(const v1::MapBuild& build, bool json) {
  absl::PrintF("%s\n", json ? BuildJson(build).dump(2)
                            : absl::StrFormat("build %s of %s: %s, %d of %d scans",
                                              build.build_id(), build.map_name(), StateText(build),
                                              build.done_scan_count(), build.scan_count()));
  return absl::OkStatus();
}

absl::Status FollowBuild(client::MapClient& maps, const v1::MapBuild& started, bool json) {
  const StopSignals signals;
  std::atomic<int> signal_count = 0;
  const std::jthread watch = signals.Watch([&](int count) {
    signal_count = count;
    if (count == 1) maps.CancelBuild(started.build_id()).status().IgnoreError();
  });
  const absl::StatusOr<v1::MapBuild> build = WaitFor(maps, started, signal_count);
  if (!build.ok()) return build.status();
  SayWhatIsLeftOut(*build);
  SayWhatWasFoundOfRadars(*build);
  SayWhatHasChanged(*build);
  if (build->state() == v1::MAP_BUILD_STATE_DONE) return PrintVersion(*build, json);
  if (build->state() == v1::MAP_BUILD_STATE_RUNNING) {
    return absl::CancelledError(absl::StrCat("build ", build->build_id(), " is still under way"));
  }
  return absl::Status(static_cast<absl::StatusCode>(build->error_code()),
                      absl::StrCat("the build was not done: ", build->error_message()));
}

}  // namespace dcloc::cli
