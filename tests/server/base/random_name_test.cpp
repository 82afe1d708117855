#include "server/base/random_name.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace dcloc::server {
namespace {

TEST(RandomNameTest, IsHexadecimalAndNeverTheSame) {
  std::set<std::string> names;
  for (int i = 0; i < 1000; ++i) names.insert(*RandomName(128, "a test"));
  EXPECT_EQ(names.size(), 1000U);
  for (const std::string& name : names) {
    ASSERT_EQ(name.size(), 32U);
    ASSERT_EQ(name.find_first_not_of("0123456789abcdef"), std::string::npos);
  }
  EXPECT_EQ(RandomName(64, "a test")->size(), 16U);
}

TEST(RandomNameTest, NoOtherNumberOfBits) {
  for (const int bits : {0, -8, 12, 264}) EXPECT_FALSE(RandomName(bits, "a test").ok()) << bits;
}

}  // namespace
}  // namespace dcloc::server
