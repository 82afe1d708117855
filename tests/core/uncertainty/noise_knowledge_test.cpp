#include "core/uncertainty/noise_knowledge.h"

#include <gtest/gtest.h>

#include <limits>

namespace dcloc {
namespace {

TEST(NoiseKnowledgeTest, NothingLearnedIsValid) { EXPECT_TRUE(Validate(NoiseKnowledge()).ok()); }

TEST(NoiseKnowledgeTest, AnErrorMayBeNegativeAndNothingElse) {
  NoiseKnowledge knowledge;
  knowledge.translation.near.error = -3.0;
  EXPECT_TRUE(Validate(knowledge).ok());
  knowledge.translation.near.odometry = -3.0;
  EXPECT_EQ(Validate(knowledge).message(),
            "noise.translation.near.odometry is -3; it must lie in [0, 1e+12]");
}

TEST(NoiseKnowledgeTest, EachNumberIsNamed) {
  using Number = double NoisePairs::*;
  for (const Number number : {&NoisePairs::error, &NoisePairs::registrations, &NoisePairs::odometry,
                              &NoisePairs::count, &NoisePairs::prior_count, &NoisePairs::number}) {
    for (NoisePairs NoisePart::*pairs : {&NoisePart::near, &NoisePart::far}) {
      for (NoisePart NoiseKnowledge::*part :
           {&NoiseKnowledge::translation, &NoiseKnowledge::rotation}) {
        NoiseKnowledge knowledge;
        ((knowledge.*part).*pairs).*number = std::numeric_limits<double>::quiet_NaN();
        EXPECT_FALSE(Validate(knowledge).ok());
        ((knowledge.*part).*pairs).*number = 1e13;
        EXPECT_FALSE(Validate(knowledge).ok());
      }
    }
  }
}

TEST(NoiseKnowledgeTest, ARatioHasABound) {
  NoiseKnowledge knowledge;
  knowledge.rotation.registration_ratio = 2e6;
  EXPECT_EQ(Validate(knowledge).message(),
            "noise.rotation.registration_ratio is 2e+06; it must lie in [0, 1e+06]");
}

}  // namespace
}  // namespace dcloc
