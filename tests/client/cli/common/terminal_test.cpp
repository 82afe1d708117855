#include "client/cli/common/terminal.h"

#include <gtest/gtest.h>

#include "client/cli/common/exit_codes.h"

namespace dcloc::cli {
namespace {

TEST(FormatTable, AlignsColumns) {
  EXPECT_EQ(FormatTable({{"", "one", "two"}, {"short", "1", "22222"}, {"longer name", "333", "4"}}),
            "             one    two\n"
            "short          1  22222\n"
            "longer name  333      4\n");
}

TEST(FormatTable, TakesRowsOfDifferentLengths) {
  EXPECT_EQ(FormatTable({{"a", "b"}, {"alone"}}), "a      b\nalone\n");
  EXPECT_EQ(FormatTable({}), "");
}

TEST(FormatBytes, ChoosesTheUnit) {
  EXPECT_EQ(FormatBytes(0.0), "0 B");
  EXPECT_EQ(FormatBytes(999.0), "999 B");
  EXPECT_EQ(FormatBytes(1000.0), "1.0 kB");
  EXPECT_EQ(FormatBytes(999'960.0), "1.0 MB");
  EXPECT_EQ(FormatBytes(2.5e12), "2.5 TB");
}

TEST(Fail, ReturnsFailureAndSaysWhy) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(Fail(absl::NotFoundError("no map")), kFailure);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "dcloc: no map\n");
}

}  // namespace
}  // namespace dcloc::cli
