#include "server/net/peer_connections.h"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <optional>

#include "server/base/files.h"

namespace dcloc::server {
namespace {

FileDescriptor Socket() { return FileDescriptor(socket(AF_INET, SOCK_STREAM, 0)); }

TEST(PeerConnectionsTest, AnAddressHasOnlySoMany) {
  PeerConnections peers(2);
  const FileDescriptor first = Socket();
  const FileDescriptor second = Socket();
  const FileDescriptor third = Socket();
  EXPECT_TRUE(peers.Add("192.0.2.1", first.get()));
  EXPECT_TRUE(peers.Add("192.0.2.1", second.get()));
  EXPECT_FALSE(peers.Add("192.0.2.1", third.get()));
  EXPECT_TRUE(peers.Add("192.0.2.2", third.get())) << "another address has its own";
}

TEST(PeerConnectionsTest, ClosedOnesDoNotCountAlsoWhenTheirDescriptorIsAnothersNow) {
  PeerConnections peers(1);
  std::optional<FileDescriptor> first = Socket();
  const int number = first->get();
  ASSERT_TRUE(peers.Add("192.0.2.1", number));
  ASSERT_FALSE(peers.Add("192.0.2.1", number));
  first.reset();
  const FileDescriptor next = Socket();
  ASSERT_EQ(next.get(), number) << "the system gives out the lowest free number";
  EXPECT_TRUE(peers.Add("192.0.2.1", next.get()));
}

}  // namespace
}  // namespace dcloc::server
