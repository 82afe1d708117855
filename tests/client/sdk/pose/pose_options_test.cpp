#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "client/sdk/pose/pose_estimate.h"

namespace dcloc::client {
namespace {

using ::testing::HasSubstr;

TEST(PoseOptionsTest, DefaultsAreValid) { EXPECT_TRUE(Validate(PoseOptions{}).ok()); }

TEST(PoseOptionsTest, ARefusalNamesTheFieldTheValueAndTheBound) {
  PoseOptions options;
  options.max_ahead = std::chrono::milliseconds(0);
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("pose.max_ahead is 0 ms"));
  options = {};
  options.bleed_mps = -1.0;
  EXPECT_THAT(std::string(Validate(options).message()), HasSubstr("pose.bleed_mps is -1"));
  options = {};
  options.velocity_sigma_mps = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Validate(options).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::client
