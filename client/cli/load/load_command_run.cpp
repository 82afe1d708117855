#include "client/cli/load/load_command_run.h"

#include <sys/resource.h>

#include <atomic>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/live_line.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/common/terminal.h"
#include "client/cli/remote/wire.h"
#include "client/datasets/dataset.h"
#include "client/evaluation/gnuplot.h"
#include "client/evaluation/perturbation.h"
#include "client/load/capacity_search.h"
#include "client/load/load_report.h"
#include "client/load/load_run.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

/// Each vehicle has a connection of its own.
void RaiseFileLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

load::Route RouteOf(const Drive& drive, const std::string& map) {
  load::Route route{.name = drive.name, .scans = {}, .true_positions_m = {}, .open = {}};
  auto poses = std::make_shared<std::vector<Pose3>>();
  for (const DriveScan& entry : drive.scans) {
    route.scans.push_back(ToProto(entry.scan, static_cast<std::int64_t>(route.scans.size())));
    route.true_positions_m.emplace_back(entry.T_map_vehicle.translation_m.head<2>());
    poses->push_back(entry.T_map_vehicle);
  }
  v1::OpenSession open;
  open.set_map_name(map);
  *open.mutable_rig() = ToProto(drive.rig);
  route.open = [open, poses, name = drive.name](std::size_t first, std::uint64_t seed) {
    v1::OpenSession opening = open;
    *opening.mutable_initial_pose() = ToProto(Perturb((*poses)[first], {}, name, seed));
    return opening;
  };
  return route;
}

absl::StatusOr<std::vector<load::Route>> ReadRoutes(const LoadArguments& arguments) {
  std::vector<load::Route> routes;
  for (const std::string& name : arguments.drives) {
    const absl::StatusOr<Drive> drive =
        ReadDrive(arguments.dataset, {.name = name, .radars = arguments.radars});
    if (!drive.ok()) return drive.status();
    routes.push_back(RouteOf(*drive, arguments.map));
  }
  return routes;
}

void PrintResult(const LoadArguments& arguments, const load::LoadResult& result,
                 const std::vector<std::string>& shortfalls) {
  if (arguments.json) {
    absl::PrintF("%s\n", load::ToJson(result, shortfalls).dump(2));
    return;
  }
  absl::PrintF("%s", FormatTable(load::TableOf({&result})));
  for (const std::string& note : load::NotesOf(result)) absl::PrintF("%s\n", note);
  if (arguments.target_p99_ms > 0.0 && shortfalls.empty()) {
    absl::PrintF("The target p99 <= %g ms is held.\n", arguments.target_p99_ms);
  }
}

void PrintCapacity(const LoadArguments& arguments, const load::Capacity& capacity) {
  if (arguments.json) {
    ordered_json probes = ordered_json::array();
    for (const load::Probe& probe : capacity.probes) {
      probes.push_back(load::ToJson(probe.result, probe.shortfalls));
    }
    absl::PrintF("%s\n", ordered_json{{"target_p99_ms", arguments.target_p99_ms},
                                      {"vehicle_count", capacity.vehicle_count},
                                      {"is_limit", capacity.is_limit},
                                      {"probes", probes}}
                             .dump(2));
    return;
  }
  std::vector<const load::LoadResult*> results;
  results.reserve(capacity.probes.size());
  for (const load::Probe& probe : capacity.probes) results.push_back(&probe.result);
  std::vector<std::vector<std::string>> rows = load::TableOf(results);
  rows[0].emplace_back("held");
  for (std::size_t i = 0; i < capacity.probes.size(); ++i) {
    rows[i + 1].emplace_back(capacity.probes[i].shortfalls.empty() ? "yes" : "no");
  }
  absl::PrintF("%s%d vehicles hold p99 <= %g ms%s\n", FormatTable(rows), capacity.vehicle_count,
               arguments.target_p99_ms,
               capacity.is_limit ? "" : "; more were not tried (--max-vehicles)");
}

absl::Status Once(const LoadArguments& arguments, const std::vector<load::Route>& routes,
                  const load::LinkFactory& make_link, const load::LoadObserver& observer) {
  const auto result = load::RunLoad(arguments.options, routes, make_link, observer);
  if (!result.ok()) return result.status();
  const std::vector<std::string> shortfalls = load::Shortfalls(*result, arguments.target_p99_ms);
  PrintResult(arguments, *result, shortfalls);
  if (!arguments.plot.empty()) {
    absl::Status status = RenderPng(load::LatencyPicture(*result), arguments.plot);
    if (!status.ok()) return status;
  }
  if (shortfalls.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrJoin(shortfalls, "; "));
}

absl::Status Search(const LoadArguments& arguments, const std::vector<load::Route>& routes,
                    const load::LinkFactory& make_link, const load::LoadObserver& observer) {
  const auto run = [&](int vehicle_count) -> absl::StatusOr<load::LoadResult> {
    load::LoadOptions options = arguments.options;
    options.vehicle_count = vehicle_count;
    absl::StatusOr<load::LoadResult> result = load::RunLoad(options, routes, make_link, observer);
    if (observer.stopped()) return absl::CancelledError("interrupted");
    return result;
  };
  const auto capacity = load::SearchCapacity(
      arguments.options.vehicle_count, arguments.max_vehicle_count, arguments.target_p99_ms, run);
  if (!capacity.ok()) return capacity.status();
  PrintCapacity(arguments, *capacity);
  if (capacity->vehicle_count > 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("not even one vehicle holds the target: ",
                   absl::StrJoin(capacity->probes.back().shortfalls, "; ")));
}

}  // namespace

absl::Status RunLoadCommand(const LoadArguments& arguments) {
  const absl::StatusOr<std::vector<load::Route>> routes = ReadRoutes(arguments);
  if (!routes.ok()) return routes.status();
  RaiseFileLimit();
  const StopSignals signals;
  std::atomic<bool> stopped = false;
  const std::jthread watcher = signals.Watch([&](int) { stopped = true; });
  const bool breaks = arguments.options.faults.disconnects_per_min > 0.0;
  const auto make_link = [&] { return load::MakeLink(arguments.server, breaks); };
  LiveLine line;
  const load::LoadObserver observer{
      .on_second = [&](const load::LoadSecond& second) { line.Show(load::LineOf(second)); },
      .stopped = [&] { return stopped.load(); }};
  absl::Status status = arguments.search ? Search(arguments, *routes, make_link, observer)
                                         : Once(arguments, *routes, make_link, observer);
  if (stopped && status.ok()) return absl::CancelledError("interrupted before the end");
  if (!absl::IsUnavailable(status)) return status;
  return absl::UnavailableError(absl::StrCat(arguments.server.server, ": ", status.message()));
}

}  // namespace dcloc::cli
