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

TEST(FormatTable, ShowsWhatOthersChoseAsText) {
  EXPECT_EQ(FormatTable({{"drive"}, {"\x1b[2J\nA map"}}), "drive\n\\x1b[2J\\nA map\n");
}

TEST(Visible, LeavesTextAsItIs) {
  for (const char* text : {"", "town-1", "Straße 36 °", "道路", "a\\b \"c\"", "\U0001F697"}) {
    EXPECT_EQ(Visible(text), text);
  }
}

TEST(Visible, WritesControlCharactersOut) {
  EXPECT_EQ(Visible("\x1b]0;x\x07"), "\\x1b]0;x\\x07");
  EXPECT_EQ(Visible("a\r\n\tb\x7f"), "a\\r\\n\\tb\\x7f");
  EXPECT_EQ(Visible(std::string("\0", 1)), "\\x00");
  EXPECT_EQ(Visible("\xc2\x9b"
                    "2J"),
            "\\xc2\\x9b2J")
      << "the one-character form of ESC [";
  EXPECT_EQ(Visible("\u202egpj"), "\\xe2\\x80\\xaegpj") << "turns the direction of writing";
  EXPECT_EQ(Visible("\u2066x"), "\\xe2\\x81\\xa6x");
}

TEST(Visible, WritesOutWhatIsNoText) {
  EXPECT_EQ(Visible("\xff\xc3"), "\\xff\\xc3");
  EXPECT_EQ(Visible("\xe2\x80"), "\\xe2\\x80");
  EXPECT_EQ(Visible("\xc0\x9b"), "\\xc0\\x9b");
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

TEST(Fail, KeepsLinesAndShowsTheRestAsText) {
  ::testing::internal::CaptureStderr();
  Fail(absl::NotFoundError("no\nmap \x1b[31m"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "dcloc: no\nmap \\x1b[31m\n");
}

TEST(Fail, ReturnsFailureAndSaysWhy) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(Fail(absl::NotFoundError("no map")), kFailure);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "dcloc: no map\n");
}

}  // namespace
}  // namespace dcloc::cli
