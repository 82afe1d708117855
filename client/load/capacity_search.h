#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load/load_run.h"

namespace dcloc::load {

/// One run of a search.
struct Probe {
  LoadResult result;
  std::vector<std::string> shortfalls;  ///< none: it holds
};

struct Capacity {
  int vehicle_count = 0;      ///< the most that held; 0 when not even one did
  bool is_limit = false;      ///< more were tried and did not hold
  std::vector<Probe> probes;  ///< in the order in which they ran
};

/// The most vehicles that hold a target: doubles from `first` while they hold, up to `max`, and
/// then halves the gap until it is at most a sixteenth. `run` makes one run; its errors end the
/// search. InvalidArgument for a `max` below 1 and a target that is not above 0.
absl::StatusOr<Capacity> SearchCapacity(
    int first, int max, double target_p99_ms,
    const std::function<absl::StatusOr<LoadResult>(int vehicle_count)>& run);

}  // namespace dcloc::load
