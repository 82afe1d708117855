#include "client/cli/remote/answer_text.h"

#include <gtest/gtest.h>

namespace dcloc::cli {
namespace {

TEST(AgeTextTest, HasAFittingUnit) {
  EXPECT_EQ(AgeText(0.25), "250 ms");
  EXPECT_EQ(AgeText(30.0), "30 s");
  EXPECT_EQ(AgeText(600.0), "10 min");
  EXPECT_EQ(AgeText(36000.0), "10 h");
}

}  // namespace
}  // namespace dcloc::cli
