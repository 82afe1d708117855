#include "client/datasets/can_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

Stamp At(int ms) { return Stamp(milliseconds(ms)); }

VelocityLog Ramp() {
  return VelocityLog({{At(1000), {1.0, 0.0, 0.0}, {0.0, 0.0, 0.1}},
                      {At(1020), {2.0, 0.0, 0.0}, {0.0, 0.0, 0.3}},
                      {At(2000), {9.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}});
}

TEST(VelocityLog, InterpolatesBetweenSamples) {
  const auto velocity = Ramp().At(At(1015), milliseconds(100));
  ASSERT_TRUE(velocity.has_value());
  EXPECT_NEAR(velocity->linear_mps.x(), 1.75, 1e-12);
  EXPECT_NEAR(velocity->angular_radps.z(), 0.25, 1e-12);
  EXPECT_FALSE(velocity->covariance.has_value());
}

TEST(VelocityLog, TakesTheNearestAtTheEndsAndAroundGaps) {
  const VelocityLog log = Ramp();
  EXPECT_EQ(log.At(At(950), milliseconds(100))->linear_mps.x(), 1.0);
  EXPECT_EQ(log.At(At(1000), milliseconds(100))->linear_mps.x(), 1.0);
  EXPECT_EQ(log.At(At(1100), milliseconds(100))->linear_mps.x(), 2.0);
  EXPECT_EQ(log.At(At(1930), milliseconds(100))->linear_mps.x(), 9.0);
  EXPECT_EQ(log.At(At(2100), milliseconds(100))->linear_mps.x(), 9.0);
}

TEST(VelocityLog, IsSilentFarFromAnySample) {
  const VelocityLog log = Ramp();
  EXPECT_FALSE(log.At(At(899), milliseconds(100)).has_value());
  EXPECT_FALSE(log.At(At(1500), milliseconds(100)).has_value());
  EXPECT_FALSE(log.At(At(2101), milliseconds(100)).has_value());
  EXPECT_FALSE(VelocityLog({}).At(At(1000), milliseconds(100)).has_value());
}

TEST(ReadCanBusPose, NamesFileAndFault) {
  const TempFolder folder;
  const std::string record = R"({"utime": 5, "vel": [1, 0, 0], "rotation_rate": [0, 0, 0]})";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[" + record + "," + record + "]", "record 1: \"utime\" is not after"},
      {R"([{"utime": -9223372036854775808, "vel": [1, 0, 0], "rotation_rate": [0, 0, 0]}])",
       "\"utime\" is -9223372036854775808; it must be a time within"},
      {R"([{"utime": 5, "vel": [1, 0, 0]}])", "\"rotation_rate\" is missing"},
      {R"([{"utime": 5, "vel": [1, 0], "rotation_rate": [0, 0, 0]}])", "\"vel\" has 2 numbers"},
      {"[" + record, "not valid JSON"},
  };
  for (const auto& [text, fault] : cases) {
    const auto path = folder.Write("scene-0001_pose.json", text);
    const auto log = ReadCanBusPose(path);
    ASSERT_FALSE(log.ok()) << fault;
    EXPECT_THAT(std::string(log.status().message()),
                AllOf(HasSubstr(path.string()), HasSubstr(fault)));
  }
}

}  // namespace
}  // namespace dcloc
