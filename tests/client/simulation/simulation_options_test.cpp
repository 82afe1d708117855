#include "client/simulation/simulation_options.h"

#include <gtest/gtest.h>

#include "tests/client/fixtures/field_cases.h"

namespace dcloc {
namespace {

TEST(SimulationOptionsTest, EachFieldIsValidated) {
  // A field that is added does not compile here until it has a row below.
  [[maybe_unused]] const auto& [world, radar, noise, rig_size, seed, length_m, tunnel_m, loop_m,
                                both_ways, map_speed_mps, live_speeds_mps, stops, signal_rate_hz,
                                scan_rate_hz, noise_scale, is_flat, beta_s, has_elevation,
                                unambiguous_range_rate_mps, range_rate_step_mps,
                                parked_change_share, clutter_share, ghost_share, day, vehicle_count,
                                ageing] = SimulationOptions{};
  [[maybe_unused]] const auto& [replaced_share, site_m, post_count, gone_wall_m, leaf_count] =
      ageing;
  ExpectEachFieldIsValidated<SimulationOptions>(
      {},
      {{"rig_size",
        [](auto& o, double v) { o.rig_size = static_cast<int>(v); },
        {.nan = kIsAnInteger}},
       {"length_m", [](auto& o, double v) { o.length_m = v; }, {}},
       {"tunnel_m", [](auto& o, double v) { o.tunnel_m = v; }, {.zero = "no tunnel"}},
       {"loop_m", [](auto& o, double v) { o.loop_m = v; }, {.zero = "a street with two ends"}},
       {"map_speed_mps", [](auto& o, double v) { o.map_speed_mps = v; }, {}},
       {"live_speeds_mps[0]", [](auto& o, double v) { o.live_speeds_mps = {v}; }, {}},
       {"scan_rate_hz", [](auto& o, double v) { o.scan_rate_hz = v; }, {.zero = "as its kind"}},
       {"signal_rate_hz", [](auto& o, double v) { o.signal_rate_hz = v; }, {}},
       {"noise_scale", [](auto& o, double v) { o.noise_scale = v; }, {.zero = "no noise"}},
       {"beta_s", [](auto& o, double v) { o.beta_s = v; }, {.zero = "no coupling"}},
       {"unambiguous_range_rate_mps",
        [](auto& o, double v) { o.unambiguous_range_rate_mps = v; },
        {.zero = "no aliasing"}},
       {"range_rate_step_mps",
        [](auto& o, double v) { o.range_rate_step_mps = v; },
        {.zero = "not quantised"}},
       {"parked_change_share",
        [](auto& o, double v) { o.parked_change_share = v; },
        {.zero = "all stay"}},
       {"day",
        [](auto& o, double v) { o.day = static_cast<int>(v); },
        {.nan = kIsAnInteger, .zero = "the first day"}},
       {"vehicle_count",
        [](auto& o, double v) { o.vehicle_count = static_cast<int>(v); },
        {.nan = kIsAnInteger}},
       {"ageing.replaced_share",
        [](auto& o, double v) { o.ageing.replaced_share = v; },
        {.zero = "none"}},
       {"ageing.site_m", [](auto& o, double v) { o.ageing.site_m = v; }, {.zero = "none"}},
       {"ageing.post_count",
        [](auto& o, double v) { o.ageing.post_count = static_cast<int>(v); },
        {.nan = kIsAnInteger, .zero = "none"}},
       {"ageing.gone_wall_m",
        [](auto& o, double v) { o.ageing.gone_wall_m = v; },
        {.zero = "none"}},
       {"ageing.leaf_count",
        [](auto& o, double v) { o.ageing.leaf_count = static_cast<int>(v); },
        {.nan = kIsAnInteger, .zero = "none"}},
       {"clutter_share", [](auto& o, double v) { o.clutter_share = v; }, {.zero = "no clutter"}},
       {"ghost_share", [](auto& o, double v) { o.ghost_share = v; }, {.zero = "no ghosts"}}});
}

TEST(SimulationOptionsTest, ARingIsOfATownOnly) {
  SimulationOptions options{.loop_m = 1500.0, .both_ways = true};
  EXPECT_TRUE(Validate(options).ok()) << Validate(options);
  options.tunnel_m = 100.0;
  EXPECT_FALSE(Validate(options).ok());
  options = {.world = WorldKind::kHighway, .loop_m = 1500.0};
  EXPECT_FALSE(Validate(options).ok());
  EXPECT_FALSE(Validate(SimulationOptions{.both_ways = true}).ok());
}

TEST(PassOptionsTest, EachFieldIsValidated) {
  [[maybe_unused]] const auto& [name, index, mean_speed_mps, begin_m, is_reversed] = PassOptions{};
  ExpectEachFieldIsValidated<PassOptions>(
      {},
      {{"pass index",
        [](auto& o, double v) { o.index = static_cast<int>(v); },
        {.nan = kIsAnInteger, .zero = "the map pass"}},
       {"pass begin_m", [](auto& o, double v) { o.begin_m = v; }, {.zero = "where drives begin"}},
       {"pass mean_speed_mps", [](auto& o, double v) { o.mean_speed_mps = v; }, {}}});
}

}  // namespace
}  // namespace dcloc
