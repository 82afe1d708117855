#include "server/base/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(CheckTest, BoundsBelongToTheRangeAndNanToNone) {
  EXPECT_TRUE(CheckBetween("rate", 1.0, 1.0, 2.0).ok());
  EXPECT_TRUE(CheckBetween("rate", 2.0, 1.0, 2.0).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {0.5, 2.5, nan}) {
    const absl::Status status = CheckBetween("rate", value, 1.0, 2.0);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << value;
    EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("rate is "), HasSubstr("[1, 2]")));
  }
  EXPECT_TRUE(CheckIntegerBetween("size", 3, 3, 3).ok());
  EXPECT_THAT(MessageOf(CheckIntegerBetween("size", 4, 1, 3)),
              AllOf(HasSubstr("size is 4"), HasSubstr("[1, 3]")));
}

TEST(CheckTest, IdsHaveWhatMayStandInALogAsItIs) {
  for (const char* id : {"a", "Car_1.front:left-2"}) EXPECT_TRUE(CheckId("id", id).ok()) << id;
  EXPECT_TRUE(CheckId("id", std::string(64, 'x')).ok());
  for (const std::string& id : {std::string(), std::string(65, 'x'), std::string("a b"),
                                std::string("a/b"), std::string("a\nb")}) {
    EXPECT_THAT(MessageOf(CheckId("id", id)), HasSubstr("id is ")) << id;
  }
}

TEST(CheckTest, MapNamesBeginWithALetterOrADigitAndHoldNoSlash) {
  for (const char* name : {"a", "7", "town-2_east"}) {
    EXPECT_TRUE(CheckMapName("map_name", name).ok()) << name;
  }
  for (const std::string& name : {std::string(), std::string(64, 'x'), std::string("-a"),
                                  std::string("Town"), std::string("acme/town")}) {
    EXPECT_THAT(MessageOf(CheckMapName("map_name", name)), HasSubstr("map_name is ")) << name;
  }
}

}  // namespace
}  // namespace dcloc::server
