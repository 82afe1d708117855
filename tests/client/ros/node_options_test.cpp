#include "client/ros/node_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc::node {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::map<std::string, ParameterValue> Needed() {
  return {{"map", std::string("town")}, {"mapping", std::string("dcloc_bag.json")}};
}

std::string ErrorOf(const std::string& name, ParameterValue value) {
  auto parameters = Needed();
  parameters[name] = std::move(value);
  const auto options = OptionsOf(parameters);
  return options.ok() ? "" : std::string(options.status().message());
}

TEST(NodeOptionsTest, ParametersAreTakenAndOthersKeepTheirDefaults) {
  auto parameters = Needed();
  parameters["odometry_rate_hz"] = 100.0;
  parameters["publish_tf"] = false;
  const auto options = OptionsOf(parameters);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->map, "town");
  EXPECT_EQ(options->odometry_rate_hz, 100.0);
  EXPECT_FALSE(options->publish_tf);
  EXPECT_EQ(options->server, "localhost:50051");
}

TEST(NodeOptionsTest, ErrorsNameTheParameterItsValueAndTheBound) {
  EXPECT_THAT(ErrorOf("odometry_rate_hz", -1.0),
              AllOf(HasSubstr("~odometry_rate_hz is -1"), HasSubstr("[0, 1000]")));
  EXPECT_THAT(ErrorOf("fix_sigma_m", 0.0), HasSubstr("~fix_sigma_m is 0"));
  EXPECT_THAT(ErrorOf("map", 3.0), AllOf(HasSubstr("~map is 3"), HasSubstr("a text")));
  EXPECT_THAT(ErrorOf("publish_tf", std::string("yes")),
              AllOf(HasSubstr("~publish_tf is \"yes\""), HasSubstr("true or false")));
  EXPECT_THAT(ErrorOf("fix_sigma_m", true), AllOf(HasSubstr("is true"), HasSubstr("a number")));
  EXPECT_THAT(ErrorOf("map", std::string()), HasSubstr("~map is empty"));
  EXPECT_THAT(ErrorOf("maps", std::string("town")), HasSubstr("~maps is no parameter"));
  EXPECT_EQ(ErrorOf("vehicle", std::string("car-17")), "");
  EXPECT_THAT(std::string(OptionsOf({}).status().message()), HasSubstr("~map is empty"));
}

}  // namespace
}  // namespace dcloc::node
