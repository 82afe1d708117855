#include "server/base/traceparent.h"

#include <gtest/gtest.h>

#include <string>

namespace dcloc::server {
namespace {

TEST(TraceparentTest, TakesTheTraceIdAndIgnoresWhatIsMalformed) {
  const std::string id = "4bf92f3577b34da6a3ce929d0e0e4736";
  const std::string good = "00-" + id + "-00f067aa0ba902b7-01";
  EXPECT_EQ(TraceIdOf(good), id);
  EXPECT_EQ(TraceIdOf("cc-" + id + "-00f067aa0ba902b7-01-more"), id) << "a later version";
  for (const std::string& bad :
       {std::string(), id, good + "-more", "ff" + good.substr(2), good.substr(1),
        "00-" + std::string(32, '0') + "-00f067aa0ba902b7-01", "00-" + id + "-0000000000000000-01",
        "00-" + std::string(32, 'G') + "-00f067aa0ba902b7-01", "00_" + good.substr(3)}) {
    EXPECT_EQ(TraceIdOf(bad), "") << bad;
  }
}

}  // namespace
}  // namespace dcloc::server
