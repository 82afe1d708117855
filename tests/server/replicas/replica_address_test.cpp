#include "server/replicas/replica_address.h"

#include <gtest/gtest.h>

namespace dcloc::server {
namespace {

TEST(ReplicaAddressTest, HostAndPortAreOne) {
  for (const char* text : {"10.0.0.7:50051", "node-3.fleet:1", "[::1]:65535", "a_b:80"}) {
    EXPECT_TRUE(IsReplicaAddress(text)) << text;
  }
}

TEST(ReplicaAddressTest, OtherTargetsAreNone) {
  for (const char* text :
       {"", ":50051", "host", "host:", "host:0", "host:65536", "host:+80", "host: 80",
        "unix:/tmp/socket", "unix:80", "dns://1.2.3.4/host:80", "ipv4:1.2.3.4:80,5.6.7.8:80",
        "::1:80", "[::1:80", "[]:80", "host/path:80", "ho st:80", "h\xc3\xb6st:80"}) {
    EXPECT_FALSE(IsReplicaAddress(text)) << text;
  }
}

}  // namespace
}  // namespace dcloc::server
