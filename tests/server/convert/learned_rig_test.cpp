#include "server/convert/learned_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

TEST(ConvertLearnedRigTest, ARigThatCannotHaveBeenLearnedIsRefusedByName) {
  v1::LearnedRig message;
  message.mutable_wheel_scale()->set_value(1.0);
  const auto without_sigma = convert::FromProto(message, "open.learned_rig");
  EXPECT_THAT(std::string(without_sigma.status().message()),
              ::testing::AllOf(::testing::HasSubstr("open.learned_rig"),
                               ::testing::HasSubstr("wheel_scale")));
  message.mutable_wheel_scale()->set_sigma(-0.01);
  EXPECT_FALSE(convert::FromProto(message, "open.learned_rig").ok());
  message.mutable_wheel_scale()->set_sigma(0.01);
  EXPECT_TRUE(convert::FromProto(message, "open.learned_rig").ok());
  for (int i = 0; i < 100; ++i) message.add_radars()->set_radar_id(absl::StrCat("r", i));
  EXPECT_FALSE(convert::FromProto(message, "open.learned_rig").ok());
}

}  // namespace
}  // namespace dcloc::server
