#include "server/replicas/replica_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

TEST(ReplicaChannelsTest, AnAddressHasOneChannelUntilItsServerIsGone) {
  ReplicaChannels channels({});
  const std::shared_ptr<grpc::Channel> first = *channels.To("one:1");
  EXPECT_EQ(*channels.To("one:1"), first);
  ASSERT_TRUE(channels.To("two:1").ok());
  EXPECT_EQ(channels.count(), 2U);
  channels.KeepOnly({"one:1", "three:1"});
  EXPECT_EQ(channels.count(), 1U);
  EXPECT_EQ(*channels.To("one:1"), first) << "it goes on";
  channels.KeepOnly({});
  EXPECT_EQ(channels.count(), 0U);
  EXPECT_NE(*channels.To("one:1"), first) << "one that comes back is connected to anew";
}

TEST(ReplicaChannelsTest, AFileThatCannotBeReadIsNamed) {
  ReplicaChannels channels({.enabled = true, .ca = "/nowhere/ca.pem"});
  EXPECT_THAT(std::string(channels.To("one:1").status().message()), HasSubstr("/nowhere/ca.pem"));
  EXPECT_EQ(channels.count(), 0U);
}

}  // namespace
}  // namespace dcloc::server
