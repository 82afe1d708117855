#include "client/cli/remote/learned_rig.h"

#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include "server/convert/learned_rig.h"

namespace dcloc::cli {
namespace {

TEST(LearnedRigWireTest, WhatWasLearnedOfARigArrivesAsItWas) {
  RigKnowledge known;
  known.odometry_delay = {0.2, 1e-4};
  known.wheel_scale = {1.02, 4e-6};
  known.yaw_rate_correction = {-0.03, 1e-8};
  known.Of("front") = {.radar_id = "front",
                       .mount_yaw_error = ScalarEstimate{0.05, 1e-6},
                       .clock_ahead = ScalarEstimate{0.4, 1e-2},
                       .stamp_delay = ScalarEstimate{0.11, 4e-5},
                       .range_bias_error = ScalarEstimate{-0.4, 1e-3},
                       .beta_error = ScalarEstimate{0.01, 1e-6}};
  const v1::LearnedRig message = ToProto(known);
  const auto arrived = server::convert::FromProto(message, "open.learned_rig");
  ASSERT_TRUE(arrived.ok()) << arrived.status();
  v1::LearnedRig told;
  told.add_radars()->set_radar_id("of the answer before");
  server::convert::ToProto(*arrived, &told);
  EXPECT_TRUE(google::protobuf::util::MessageDifferencer::ApproximatelyEquals(told, message))
      << told.DebugString();
  EXPECT_FALSE(HasChanged(known, FromProto(told)));
  EXPECT_FALSE(HasChanged(FromProto(told), known));
}

}  // namespace
}  // namespace dcloc::cli
