#include "server/app/part_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

TEST(PartOptionsTest, ThereAreAsManyWorkersAsAreAskedForOrAsCores) {
  ServerConfig config;
  config.worker_count = 2;
  EXPECT_EQ(WorkerCount(config), 2);
  config.worker_count = 0;  // as many as the machine has cores
  EXPECT_GE(WorkerCount(config), 1);
}

TEST(PartOptionsTest, SettingsKeepTheirUnits) {
  ServerConfig config;
  config.session_detached_timeout_ms = 1'500;
  config.session_idle_timeout_ms = 2'500;
  EXPECT_EQ(SessionTimeoutsOf(config).detached_timeout, std::chrono::milliseconds(1'500));
  EXPECT_EQ(SessionTimeoutsOf(config).idle_timeout, std::chrono::milliseconds(2'500));
  config.warm_map_mib = 4'096;  // more bytes than 32 bits count
  config.unfinished_upload_timeout_s = 90;
  config.quarantine_days = 3;
  const MapStoreOptions options = MapStoreOptionsOf(config);
  EXPECT_EQ(options.max_warm_bytes, std::int64_t{4'294'967'296});
  EXPECT_EQ(options.unfinished_upload_timeout, std::chrono::seconds(90));
  EXPECT_EQ(options.quarantine_time, std::chrono::hours(72));
}

TEST(PartOptionsTest, WithoutKeysThereAreNoTickets) {
  const auto tickets = TicketsOf(ServerConfig());
  ASSERT_TRUE(tickets.ok()) << tickets.status();
  EXPECT_EQ(*tickets, nullptr);
}

TEST(PartOptionsTest, OthersAreToldAnAddressThatTheyCanReach) {
  const auto told = [](const char* address) {
    ServerConfig config;
    config.replica_address = address;
    return ReplicaAddressOf(config, 50051);
  };
  EXPECT_EQ(told("node-1").value_or(""), "node-1:50051");
  EXPECT_EQ(told("node-1:0").value_or(""), "node-1:50051");
  EXPECT_EQ(told("10.0.0.7:6000").value_or(""), "10.0.0.7:6000");
  for (const char* address : {"0.0.0.0", "[::]:50051", "node 1"}) {
    EXPECT_THAT(MessageOf(told(address).status()), HasSubstr("replica_address is")) << address;
  }
}

}  // namespace
}  // namespace dcloc::server
