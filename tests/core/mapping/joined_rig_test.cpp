#include "core/mapping/joined_rig.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

Rig One(double beta_s) {
  RadarModel radar{.id = "front"};
  radar.beta_s = beta_s;
  return {.radars = {radar}};
}

TEST(JoinedRigTest, RadarsThatAreDescribedAlikeAreOne) {
  JoinedRig joined;
  joined.Add("a", One(0.01));
  joined.Add("b", One(0.01));
  EXPECT_EQ(joined.rig().radars.size(), 1U);
  EXPECT_EQ(joined.IdOf("b", One(0.01).radars[0]), "front");
}

TEST(JoinedRigTest, OtherOnesOfTheSameIdAreNamedAfterTheirDrive) {
  JoinedRig joined;
  joined.Add("a", One(0.01));
  joined.Add("b", One(0.02));
  ASSERT_EQ(joined.rig().radars.size(), 2U);
  EXPECT_EQ(joined.IdOf("a", One(0.01).radars[0]), "front");
  EXPECT_EQ(joined.IdOf("b", One(0.02).radars[0]), "front@b");
  EXPECT_EQ(joined.rig().Find("front@b")->beta_s, 0.02);
}

}  // namespace
}  // namespace dcloc
