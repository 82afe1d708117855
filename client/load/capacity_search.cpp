#include "client/load/capacity_search.h"

#include <algorithm>
#include <utility>

#include "client/datasets/files/check_range.h"

namespace dcloc::load {
namespace {

constexpr int kGapShare = 16;

}  // namespace

absl::StatusOr<Capacity> SearchCapacity(
    int first, int max, double target_p99_ms,
    const std::function<absl::StatusOr<LoadResult>(int vehicle_count)>& run) {
  absl::Status status = CheckRange("max", max, 1, 1e6);
  status.Update(CheckRange("target_p99_ms", target_p99_ms, 1e-6, 1e9));
  if (!status.ok()) return status;
  Capacity capacity;
  int held = 0;
  int failed = max + 1;  // not tried
  int next = std::clamp(first, 1, max);
  while (true) {
    absl::StatusOr<LoadResult> result = run(next);
    if (!result.ok()) return result.status();
    Probe probe{.result = *std::move(result), .shortfalls = {}};
    probe.shortfalls = Shortfalls(probe.result, target_p99_ms);
    const bool holds = probe.shortfalls.empty();
    capacity.probes.push_back(std::move(probe));
    (holds ? held : failed) = next;
    capacity.is_limit = failed <= max;
    if (failed - held <= std::max(1, held / kGapShare)) break;
    next = capacity.is_limit ? held + (failed - held) / 2 : std::min(2 * held, max);
  }
  capacity.vehicle_count = held;
  return capacity;
}

}  // namespace dcloc::load
