#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/evaluation/disturbance.h"
#include "client/evaluation/robustness/trials.h"
#include "client/evaluation/runner.h"
#include "tests/client/fixtures/field_cases.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

TEST(EvaluationOptionsTest, EachFieldIsValidated) {
  // A field that is added does not compile here until it has a row below; `localizer` has a test
  // of its own in core.
  [[maybe_unused]] const auto& [method, protocol, has_initial_pose, perturbation,
                                doppler_ego_velocity, map_heights, query_interval_s, first_query_s,
                                localizer] = EvaluationOptions{};
  [[maybe_unused]] const auto& [translation_m, rotation_deg, seed] = Perturbation{};
  ExpectEachFieldIsValidated<EvaluationOptions>(
      {}, {{"perturbation.translation_m",
            [](auto& o, double v) { o.perturbation.translation_m = v; },
            {.zero = "at the true position"}},
           {"perturbation.rotation_deg",
            [](auto& o, double v) { o.perturbation.rotation_deg = v; },
            {.zero = "with the true heading"}},
           {"query_interval_s", [](auto& o, double v) { o.query_interval_s = v; }, {}},
           {"first_query_s",
            [](auto& o, double v) { o.first_query_s = v; },
            {.zero = "at the first scan"}}});
}

TEST(EvaluateTest, ANullMapIsAnError) {
  const absl::Status status = Evaluate(nullptr, {.scans = {{}}}, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), "map is null");
}

TEST(DisturbancePlanTest, EachFieldIsValidated) {
  [[maybe_unused]] const auto& [kinds, interval_s, burst_scans, outlier_share, gap_s, seed] =
      DisturbancePlan{};
  ExpectEachFieldIsValidated<DisturbancePlan>(
      {.kinds = {DisturbanceKind::kGap}},
      {{"interval_s", [](auto& o, double v) { o.interval_s = v; }, {}},
       {"burst_scans",
        [](auto& o, double v) { o.burst_scans = static_cast<int>(v); },
        {.nan = kIsAnInteger}},
       {"outlier_share", [](auto& o, double v) { o.outlier_share = v; }, {.zero = "no outliers"}},
       {"gap_s", [](auto& o, double v) { o.gap_s = v; }, {}}});
}

TEST(DisturbTest, AScanOfAnUnknownRadarIsAnError) {
  Drive drive{.name = "street", .rig = {.radars = {{.id = "front"}}}};
  drive.scans.push_back({.scan = {.radar_id = "rear"}});
  const absl::Status status = Disturb(drive, {.kinds = {DisturbanceKind::kOutliers}}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("radar 'rear'"));
}

}  // namespace
}  // namespace dcloc

namespace dcloc::robustness {
namespace {

// What `Validate` takes, of trials of one kind.
TrackTrial& Track(Trial& trial) { return std::get<TrackTrial>(trial); }
StartTrial& Start(Trial& trial) { return std::get<StartTrial>(trial); }

TEST(TrialTest, EachFieldIsValidated) {
  [[maybe_unused]] const auto& [track_prior, plan, session_s] = TrackTrial{};
  [[maybe_unused]] const auto& [prior, perturbation, spacing_m, limit_s] = StartTrial{};
  ExpectEachFieldIsValidated<Trial>(
      TrackTrial{.plan = DisturbancePlan{.kinds = {DisturbanceKind::kGap}}},
      {{"perturbation.translation_m",
        [](auto& o, double v) { Track(o).prior.translation_m = v; },
        {.zero = "at the true position"}},
       {"gap_s", [](auto& o, double v) { Track(o).plan->gap_s = v; }, {}},
       {"session_s", [](auto& o, double v) { Track(o).session_s = v; }, {}}});
  ExpectEachFieldIsValidated<Trial>(
      StartTrial{}, {{"perturbation.rotation_deg",
                      [](auto& o, double v) { Start(o).perturbation.rotation_deg = v; },
                      {.zero = "with the true heading"}},
                     {"spacing_m", [](auto& o, double v) { Start(o).spacing_m = v; }, {}},
                     {"limit_s", [](auto& o, double v) { Start(o).limit_s = v; }, {}}});
}

TEST(RunTrialTest, ANullMapIsAnError) {
  const absl::Status status =
      RunTrial(StartTrial{}, {.live = {.scans = {{}}}}, nullptr, [](double) {}).status();
  EXPECT_EQ(status.message(), "map is null");
}

}  // namespace
}  // namespace dcloc::robustness
