#include "client/ros/diagnostics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace dcloc::node {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Level = Diagnostic::Level;
using std::chrono::milliseconds;

const std::chrono::steady_clock::time_point kNow{std::chrono::seconds(100)};

NodeState Tracking() {
  NodeState state;
  state.link = {.phase = LinkStatus::Phase::kOpen, .session_id = "s-1", .map_version = 3};
  state.newest.emplace();
  state.newest->set_state(v1::LOCALIZATION_STATE_TRACKING);
  state.newest->set_protection_level_m(0.84);
  v1::Health& health = *state.newest->mutable_health();
  health.mutable_wheel_speed()->set_used(true);
  health.mutable_wheel_speed()->set_fault(v1::SOURCE_FAULT_NONE);
  *health.mutable_yaw_rate() = health.wheel_speed();
  v1::RadarHealth& radar = *health.add_radars();
  radar.set_radar_id("front");
  radar.set_used(true);
  radar.set_fault(v1::SOURCE_FAULT_NONE);
  state.newest_at = kNow - milliseconds(50);
  return state;
}

std::map<std::string, TopicState> Topics() {
  return {{"/front", {.message_count = 7, .newest = kNow - milliseconds(50)}}};
}

std::string ValueOf(const Diagnostic& entry, const std::string& key) {
  const auto found =
      std::ranges::find(entry.values, key, [](const auto& value) { return value.first; });
  return found == entry.values.end() ? "not there" : found->second;
}

TEST(DiagnosticsTest, ATrackedVehicleIsFine) {
  const auto entries = DiagnosticsOf(Tracking(), Topics(), kNow);
  ASSERT_EQ(entries.size(), 3U);
  for (const Diagnostic& entry : entries) EXPECT_EQ(entry.level, Level::kOk) << entry.name;
  EXPECT_EQ(entries[0].message, "tracking");
  EXPECT_EQ(ValueOf(entries[0], "protection_level_m"), "0.84");
  EXPECT_EQ(ValueOf(entries[0], "session"), "s-1");
  EXPECT_EQ(ValueOf(entries[1], "front"), "used, none");
}

TEST(DiagnosticsTest, StatesHaveTheirLevels) {
  NodeState state = Tracking();
  state.newest->set_state(v1::LOCALIZATION_STATE_DEAD_RECKONING);
  EXPECT_EQ(DiagnosticsOf(state, {}, kNow)[0].level, Level::kWarn);
  EXPECT_EQ(DiagnosticsOf(state, {}, kNow)[0].message, "dead_reckoning");
  state.newest->set_state(v1::LOCALIZATION_STATE_LOST);
  EXPECT_EQ(DiagnosticsOf(state, {}, kNow)[0].level, Level::kError);
  state.newest->clear_protection_level_m();
  EXPECT_EQ(ValueOf(DiagnosticsOf(state, {}, kNow)[0], "protection_level_m"), "none");
}

TEST(DiagnosticsTest, AServerThatIsGoneOrSilentIsAnError) {
  NodeState state = Tracking();
  const Diagnostic silent = DiagnosticsOf(state, {}, kNow + std::chrono::seconds(2))[0];
  EXPECT_EQ(silent.level, Level::kError);
  EXPECT_EQ(silent.message, "no answers");
  EXPECT_EQ(ValueOf(silent, "protection_level_m"), "none") << "an old level is worth nothing";
  state.link.phase = LinkStatus::Phase::kReconnecting;
  state.link.text = "connection refused";
  const Diagnostic gone = DiagnosticsOf(state, {}, kNow)[0];
  EXPECT_EQ(gone.level, Level::kError);
  EXPECT_EQ(gone.message, "reconnecting: connection refused");
}

TEST(DiagnosticsTest, ASourceThatIsSetAsideIsNamedWithItsFault) {
  NodeState state = Tracking();
  state.newest->mutable_health()->mutable_radars(0)->set_used(false);
  state.newest->mutable_health()->mutable_radars(0)->set_fault(v1::SOURCE_FAULT_MOUNT);
  const Diagnostic sources = DiagnosticsOf(state, {}, kNow)[1];
  EXPECT_EQ(sources.level, Level::kWarn);
  EXPECT_EQ(sources.message, "not used: front (mount)");
}

TEST(DiagnosticsTest, TopicsThatAreSilentOrWrongAreNamed) {
  auto topics = Topics();
  topics["/wheels"];
  const Diagnostic silent = DiagnosticsOf(Tracking(), topics, kNow)[2];
  EXPECT_EQ(silent.level, Level::kWarn);
  EXPECT_EQ(silent.message, "topic /wheels: nothing comes");
  topics["/front"].error = "topic /front: has no field \"v\"";
  const Diagnostic wrong = DiagnosticsOf(Tracking(), topics, kNow)[2];
  EXPECT_EQ(wrong.level, Level::kError);
  EXPECT_THAT(wrong.message, AllOf(HasSubstr("no field"), HasSubstr("/wheels")));
}

}  // namespace
}  // namespace dcloc::node
