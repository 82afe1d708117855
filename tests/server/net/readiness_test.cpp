#include "server/net/readiness.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

TEST(ReadinessTest, TellsTheLastProbe) {
  absl::Status next;
  Readiness readiness([&next] { return next; });
  EXPECT_FALSE(readiness.status().ok()) << "nothing is known yet";
  readiness.Check();
  EXPECT_TRUE(readiness.status().ok());
  next = absl::UnavailableError("gone");
  EXPECT_TRUE(readiness.status().ok());
  readiness.Check();
  EXPECT_EQ(readiness.status().message(), "gone");
}

}  // namespace
}  // namespace dcloc::server
