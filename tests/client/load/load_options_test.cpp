#include "client/load/load_options.h"

#include <gtest/gtest.h>

#include "client/load/capacity_search.h"
#include "tests/client/fixtures/field_cases.h"

namespace dcloc::load {
namespace {

std::chrono::milliseconds Ms(double value) {
  return std::chrono::milliseconds(static_cast<int>(value));
}

TEST(LoadOptionsTest, EachFieldIsValidated) {
  // A field that is added does not compile here until it has a row below.
  [[maybe_unused]] const auto& [vehicle_count, open_loop, duration, warmup, ramp, drain,
                                arrival_jitter, pace, begin_within, queue_policy, faults, seed] =
      LoadOptions{};
  [[maybe_unused]] const auto& [disconnects_per_min, stalls_per_min, stall_duration,
                                slow_reader_share, slow_read_interval, duplicate_share,
                                reorder_share] = FaultProfile{};
  constexpr Allowed kNoFault{.zero = "no such fault"};
  ExpectEachFieldIsValidated<LoadOptions>(
      {},
      {{"vehicle_count",
        [](auto& o, double v) { o.vehicle_count = static_cast<int>(v); },
        {.nan = kIsAnInteger}},
       {"duration", [](auto& o, double v) { o.duration = Ms(v); }, {.nan = kIsAnInteger}},
       {"warmup",
        [](auto& o, double v) { o.warmup = Ms(v); },
        {.nan = kIsAnInteger, .zero = "measured at once"}},
       {"ramp",
        [](auto& o, double v) { o.ramp = Ms(v); },
        {.nan = kIsAnInteger, .zero = "all begin together"}},
       {"drain",
        [](auto& o, double v) { o.drain = Ms(v); },
        {.nan = kIsAnInteger, .zero = "the last answers are not waited for"}},
       {"arrival_jitter",
        [](auto& o, double v) { o.arrival_jitter = Ms(v); },
        {.nan = kIsAnInteger, .zero = "no jitter"}},
       {"pace", [](auto& o, double v) { o.pace = v; }, {}},
       {"begin_within",
        [](auto& o, double v) { o.begin_within = v; },
        {.zero = "all begin at the start"}},
       {"faults.disconnects_per_min", [](auto& o, double v) { o.faults.disconnects_per_min = v; },
        kNoFault},
       {"faults.stalls_per_min", [](auto& o, double v) { o.faults.stalls_per_min = v; }, kNoFault},
       {"faults.stall_duration",
        [](auto& o, double v) { o.faults.stall_duration = Ms(v); },
        {.nan = kIsAnInteger}},
       {"faults.slow_reader_share", [](auto& o, double v) { o.faults.slow_reader_share = v; },
        kNoFault},
       {"faults.slow_read_interval",
        [](auto& o, double v) { o.faults.slow_read_interval = Ms(v); },
        {.nan = kIsAnInteger}},
       {"faults.duplicate_share", [](auto& o, double v) { o.faults.duplicate_share = v; },
        kNoFault},
       {"faults.reorder_share", [](auto& o, double v) { o.faults.reorder_share = v; }, kNoFault}});
}

TEST(SearchCapacityTest, BoundsThatMakeNoSenseAreErrors) {
  const auto never = [](int) -> absl::StatusOr<LoadResult> {
    ADD_FAILURE() << "nothing is to be run";
    return LoadResult{};
  };
  EXPECT_EQ(SearchCapacity(1, 0, 50.0, never).status().message(),
            "max is 0; it must lie in [1, 1e+06]");
  EXPECT_FALSE(SearchCapacity(1, 1, 0.0, never).ok());
  EXPECT_FALSE(SearchCapacity(1, 1, std::numeric_limits<double>::quiet_NaN(), never).ok());
}

}  // namespace
}  // namespace dcloc::load
