#include "server/net/listener.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <string>

#include "server/net/listen_sockets.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

TEST(ListenerTest, LeavesFilesForOthers) {
  EXPECT_GT(Listener::MaxDescriptor(), 0);
  EXPECT_LT(Listener::MaxDescriptor(), static_cast<int>(sysconf(_SC_OPEN_MAX)));
}

TEST(ListenSocketsTest, APortIsOneServersAlone) {
  const auto first = *BindListenSockets({.host = "localhost", .port = 0}, "listen");
  const absl::Status second =
      BindListenSockets({.host = "localhost", .port = first.port}, "listen").status();
  EXPECT_EQ(second.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.message()), HasSubstr("listen is \"localhost:"));
  EXPECT_EQ(
      BindListenSockets({.host = "no.such.host.invalid", .port = 0}, "listen").status().code(),
      absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dcloc::server
