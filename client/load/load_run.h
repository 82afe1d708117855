#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load/load_options.h"
#include "client/load/recorder.h"
#include "client/load/route.h"
#include "client/load/vehicle_link.h"

namespace dcloc::load {

/// The result of a run.
struct LoadResult {
  int vehicle_count = 0;
  double measured_s = 0.0;
  double client_core_count = 0.0;  ///< processor time that this process took, by the time measured
  LoadRecord record;

  /// Scans answered a second.
  double RateHz() const;
};

/// Callbacks of a run.
struct LoadObserver {
  std::function<void(const LoadSecond&)> on_second;  ///< each second, also before the measuring
  std::function<bool()> stopped;                     ///< true ends the run early
};

/// Gives a vehicle its connection.
using LinkFactory = std::function<absl::StatusOr<VehicleLink>()>;

/// Runs the vehicles: vehicle i on route i modulo their number. Takes ramp, warm-up, duration and
/// at most `drain`. InvalidArgument for invalid options and routes, Unavailable with the first
/// reason when not one session could be opened, Cancelled when it was stopped before the measuring.
absl::StatusOr<LoadResult> RunLoad(const LoadOptions& options, const std::vector<Route>& routes,
                                   const LinkFactory& make_link, const LoadObserver& observer = {});

/// Why a run is no success, each reason a sentence: wrong, lost, refused or unsent scans, streams
/// that broke, and, where there is a target (> 0), a p99 above it.
std::vector<std::string> Shortfalls(const LoadResult& result, double target_p99_ms);

}  // namespace dcloc::load
