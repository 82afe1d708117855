#include "client/evaluation/html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dcloc {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(HtmlTest, NamesOfFilesCannotBecomeMarkup) {
  EXPECT_EQ(EscapeHtml("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
  const std::string page = HtmlPage("<script>", HtmlTable({{"drive"}, {"<img src=x>"}}));
  EXPECT_THAT(page, Not(HasSubstr("<script>")));
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_THAT(page, HasSubstr("<th>drive</th>"));
  EXPECT_THAT(page, HasSubstr("<td>&lt;img src=x&gt;</td>"));
}

TEST(HtmlTest, APictureStandsWithinAPageWithoutItsDeclaration) {
  EXPECT_EQ(InlineSvg("<?xml version=\"1.0\"?>\n<svg width=\"1\"/>"), "<svg width=\"1\"/>");
  EXPECT_EQ(InlineSvg("nothing"), "nothing");
}

}  // namespace
}  // namespace dcloc
