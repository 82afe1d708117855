#include "core/odometry/rig_knowledge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dcloc {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

RigKnowledge Scale(double value, double variance) {
  RigKnowledge known;
  known.wheel_scale = {value, variance};
  return known;
}

TEST(RigKnowledgeTest, NamesWhatIsOutOfBounds) {
  EXPECT_TRUE(Validate(RigKnowledge{}).ok());
  EXPECT_TRUE(Validate(Scale(1.02, 1e-6)).ok());
  EXPECT_THAT(std::string(Validate(Scale(3.0, 1e-6)).message()),
              AllOf(HasSubstr("wheel_scale"), HasSubstr("3"), HasSubstr("1.6")));
  EXPECT_THAT(std::string(Validate(Scale(1.0, 0.0)).message()), HasSubstr("sigma"));
  EXPECT_FALSE(Validate(Scale(std::nan(""), 1e-6)).ok());
  EXPECT_FALSE(Validate(Scale(1.0, std::nan(""))).ok());
  EXPECT_FALSE(Validate(Scale(1.0, INFINITY)).ok());
  RigKnowledge turned;
  turned.Of("front").mount_yaw_error = {1.0, 1e-6};
  EXPECT_THAT(std::string(Validate(turned).message()),
              AllOf(HasSubstr("mount_yaw_error_rad"), HasSubstr("front")));
  RigKnowledge late;
  late.Of("front").stamp_delay = {0.5, 1e-6};
  EXPECT_THAT(std::string(Validate(late).message()), HasSubstr("stamp_delay_s"));
  RigKnowledge far;
  far.Of("front").range_bias_error = {-2.5, 1e-3};
  EXPECT_THAT(std::string(Validate(far).message()), HasSubstr("range_bias_error_m"));
  RigKnowledge twice;
  twice.radars = {{.radar_id = "front"}, {.radar_id = "front"}};
  EXPECT_THAT(std::string(Validate(twice).message()), HasSubstr("twice"));
}

TEST(RigKnowledgeTest, ChangesByMoreThanADeviation) {
  EXPECT_TRUE(HasChanged({}, Scale(1.0, 1e-4)));
  EXPECT_FALSE(HasChanged(Scale(1.0, 1e-4), Scale(1.009, 1e-4)));
  EXPECT_TRUE(HasChanged(Scale(1.0, 1e-4), Scale(1.011, 1e-4)));
  EXPECT_TRUE(HasChanged(Scale(1.0, 1e-4), Scale(1.0, 2e-5))) << "it is known twice as well";
  EXPECT_TRUE(HasChanged(Scale(1.0, 1e-4), {}));
}

}  // namespace
}  // namespace dcloc
