#include "server/net/listen_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

TEST(ListenAddressTest, TakesHostsAddressesAndPorts) {
  EXPECT_EQ(ParseListenAddress("127.0.0.1:0")->ToString(), "127.0.0.1:0");
  EXPECT_EQ(ParseListenAddress("[::1]:443")->ToString(), "[::1]:443");
  EXPECT_EQ(ParseListenAddress("radar.example:50051")->host, "radar.example");
  for (const char* bad : {"", "127.0.0.1", ":50051", "127.0.0.1:", "127.0.0.1:65536", "h:-1",
                          "h:12x", "::1:443", "[]:1"}) {
    const absl::Status status = ParseListenAddress(bad).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << bad;
    EXPECT_THAT(std::string(status.message()), HasSubstr("listen")) << bad;
  }
}

TEST(ListenAddressTest, KnowsWhatOnlyThisMachineCanReach) {
  for (const char* loopback : {"127.0.0.1:1", "127.9.8.7:1", "localhost:1", "[::1]:1"}) {
    EXPECT_TRUE(ParseListenAddress(loopback)->IsLoopback()) << loopback;
  }
  for (const char* open :
       {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "128.0.0.1:1", "example:1", "localhost.example:1"}) {
    EXPECT_FALSE(ParseListenAddress(open)->IsLoopback()) << open;
  }
}

}  // namespace
}  // namespace dcloc::server
