#include "client/load/load_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstddef>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/load/scheduler.h"
#include "client/load/vehicle.h"

namespace dcloc::load {
namespace {

using Clock = Scheduler::Clock;
using Vehicles = std::vector<std::unique_ptr<Vehicle>>;

constexpr std::chrono::milliseconds kPoll(20);

absl::Status CheckRoutes(const std::vector<Route>& routes) {
  if (routes.empty()) return absl::InvalidArgumentError("there is no route to drive on");
  for (const Route& route : routes) {
    if (route.scans.empty()) {
      return absl::InvalidArgumentError(absl::StrCat("drive ", route.name, " has no scans"));
    }
  }
  return absl::OkStatus();
}

double ProcessorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Waits until `end`, telling the observer each second; false when it was stopped.
bool Watch(Clock::time_point end, Recorder& recorder, const LoadObserver& observer) {
  Clock::time_point second = Clock::now() + std::chrono::seconds(1);
  while (Clock::now() < end) {
    if (observer.stopped && observer.stopped()) return false;
    std::this_thread::sleep_until(std::min({end, second, Clock::now() + kPoll}));
    if (Clock::now() < second) continue;
    second += std::chrono::seconds(1);
    const LoadSecond passed = recorder.EndSecond();
    if (observer.on_second) observer.on_second(passed);
  }
  return true;
}

bool WaitUntilDone(const Vehicles& vehicles, Clock::time_point deadline) {
  const auto done = [](const auto& vehicle) { return vehicle->done(); };
  while (!std::ranges::all_of(vehicles, done)) {
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(kPoll);
  }
  return true;
}

void EndAll(const Vehicles& vehicles, std::chrono::milliseconds drain) {
  for (const auto& vehicle : vehicles) vehicle->Finish();
  if (WaitUntilDone(vehicles, Clock::now() + drain)) return;
  for (const auto& vehicle : vehicles) vehicle->Cancel();
  WaitUntilDone(vehicles, Clock::time_point::max());
}

}  // namespace

double LoadResult::RateHz() const {
  return measured_s > 0.0 ? static_cast<double>(record.totals.answered_count) / measured_s : 0.0;
}

absl::StatusOr<LoadResult> RunLoad(const LoadOptions& options, const std::vector<Route>& routes,
                                   const LinkFactory& make_link, const LoadObserver& observer) {
  absl::Status status = Validate(options);
  status.Update(CheckRoutes(routes));
  if (!status.ok()) return status;
  Recorder recorder;
  Vehicles vehicles;
  Scheduler scheduler;  // goes before the vehicles, and calls them no more
  const Fleet fleet{.options = options, .scheduler = scheduler, .recorder = recorder};
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < options.vehicle_count; ++i) {
    absl::StatusOr<VehicleLink> link = make_link();
    if (!link.ok()) return link.status();
    const Route& route = routes[static_cast<std::size_t>(i) % routes.size()];
    vehicles.push_back(std::make_unique<Vehicle>(i, fleet, route, *std::move(link)));
    scheduler.At(start + options.ramp * i / options.vehicle_count,
                 [vehicle = vehicles.back().get()] { vehicle->Start(); });
  }
  if (!Watch(start + options.ramp + options.warmup, recorder, observer)) {
    EndAll(vehicles, options.drain);
    return absl::CancelledError("stopped before anything was measured");
  }
  recorder.Begin();
  const Clock::time_point begin = Clock::now();
  const double begin_processor_s = ProcessorSeconds();
  Watch(begin + options.duration, recorder, observer);
  recorder.End();
  LoadResult result;
  result.measured_s = std::chrono::duration<double>(Clock::now() - begin).count();
  result.client_core_count = (ProcessorSeconds() - begin_processor_s) / result.measured_s;
  EndAll(vehicles, options.drain);
  result.vehicle_count = options.vehicle_count;
  result.record = recorder.record();
  const LoadTotals& totals = result.record.totals;
  if (totals.opened_count == 0) {
    return absl::UnavailableError(
        absl::StrCat("no session could be opened: ",
                     totals.broken.count > 0 ? totals.broken.first : "the server did not answer"));
  }
  return result;
}

std::vector<std::string> Shortfalls(const LoadResult& result, double target_p99_ms) {
  const LoadTotals& totals = result.record.totals;
  std::vector<std::string> reasons;
  const auto add = [&](std::int64_t count, const char* what, const std::string& first = "") {
    if (count == 0) return;
    reasons.push_back(absl::StrCat(count, " ", what, first.empty() ? "" : ", the first: ", first));
  };
  add(totals.violations.count, "answers break the contract", totals.violations.first);
  add(totals.lost_count, "scans were lost");
  add(totals.skipped_count, "scans could not be sent, as those before were waiting");
  add(totals.dropped_count, "scans were dropped by the server, or beyond a limit of its");
  add(totals.refused.count, "scans were refused", totals.refused.first);
  add(totals.broken.count, "streams broke", totals.broken.first);
  const double p99_ms = result.record.latency.QuantileMs(0.99);
  if (totals.answered_count == 0) reasons.emplace_back("no scan was answered in time to count");
  if (target_p99_ms > 0.0 && p99_ms > target_p99_ms) {
    reasons.push_back(
        absl::StrFormat("p99 is %.1f ms; the target is %g ms", p99_ms, target_p99_ms));
  }
  return reasons;
}

}  // namespace dcloc::load
