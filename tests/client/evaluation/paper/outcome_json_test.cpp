#include "client/evaluation/paper/outcome_json.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/client/evaluation/paper/made_outcomes.h"

namespace dcloc::paper {
namespace {

using nlohmann::json;

DriveOutcome Outcome() {
  DriveOutcome outcome = MadeOutcome({MadeScan(1.25, 0.1, 0.2, -3.5), MadeScan(2.5, 0.3, 0.4)});
  outcome.refused_count = 3;
  outcome.first_refusal = "range_m is \"-1\"";
  ScanOutcome& scan = outcome.scans[0];
  scan.answer.T_map_vehicle = {.translation_m = {1.5, -2.25, 0.125},
                               .rotation = Eigen::Quaterniond(0.6, 0.0, 0.0, 0.8)};
  scan.T_map_vehicle_true = {.translation_m = {1.0 / 3.0, 4.0, 5.0}};
  scan.answer.state = LocalizationState::kDeadReckoning;
  scan.stage_ms[1] = 0.75;
  scan.total_ms = 1.5;
  outcome.scans[1].error.nees = std::numeric_limits<double>::infinity();
  return outcome;
}

TEST(OutcomeJson, GivesBackWhatItWasGiven) {
  const DriveOutcome given = Outcome();
  // Through text, as on disk.
  const auto read = OutcomeFromJson(json::parse(OutcomeToJson(given).dump()));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->drive, given.drive);
  EXPECT_EQ(read->refused_count, 3U);
  EXPECT_EQ(read->first_refusal, given.first_refusal);
  ASSERT_EQ(read->scans.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const ScanOutcome& a = given.scans[i];
    const ScanOutcome& b = read->scans[i];
    EXPECT_EQ(a.radar_id, b.radar_id);
    EXPECT_EQ(a.answer.stamp, b.answer.stamp);
    EXPECT_EQ(a.answer.state, b.answer.state);
    EXPECT_EQ(a.answer.T_map_vehicle.translation_m, b.answer.T_map_vehicle.translation_m);
    EXPECT_EQ(a.answer.T_map_vehicle.rotation.coeffs(), b.answer.T_map_vehicle.rotation.coeffs());
    EXPECT_EQ(a.T_map_vehicle_true.translation_m, b.T_map_vehicle_true.translation_m);
    EXPECT_EQ(a.error.translation_m, b.error.translation_m);
    EXPECT_EQ(a.error.rotation_deg, b.error.rotation_deg);
    EXPECT_EQ(a.error.dof, b.error.dof);
    EXPECT_EQ(a.error.nees, b.error.nees);
    EXPECT_EQ(a.stage_ms, b.stage_ms);
    EXPECT_EQ(a.total_ms, b.total_ms);
    EXPECT_EQ(a.speed_difference_mps, b.speed_difference_mps);
  }
}

TEST(OutcomeJson, RefusesWhatIsNoOutcome) {
  const std::vector<std::function<void(json&)>> damages = {
      [](json& j) { j = 7; },
      [](json& j) { j = json::array(); },
      [](json& j) { j.erase("drive"); },
      [](json& j) { j["refused"] = "three"; },
      [](json& j) { j["scans"] = "none"; },
      [](json& j) { j["scans"][0] = json::object(); },
      [](json& j) { j["scans"][0].erase(10); },
      [](json& j) { j["scans"][0][0] = "now"; },
      [](json& j) { j["scans"][0][2] = 4; },
      [](json& j) { j["scans"][0][2] = -1; },
      [](json& j) {
        j["scans"][0][3] = {1.0, 2.0};
      },
      [](json& j) { j["scans"][0][5] = nullptr; },
      [](json& j) {
        j["scans"][0][7] = {9, 1.0};
      },
      [](json& j) { j["scans"][0][8] = json::array(); },
      [](json& j) { j["scans"][1][10] = "fast"; },
  };
  for (std::size_t i = 0; i < damages.size(); ++i) {
    json damaged = OutcomeToJson(Outcome());
    damages[i](damaged);
    EXPECT_FALSE(OutcomeFromJson(damaged).has_value()) << "damage " << i;
  }
}

}  // namespace
}  // namespace dcloc::paper
