#include "server/net/self_probe.h"

#include <gtest/gtest.h>

#include <chrono>

#include "server/net/listen_sockets.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/test_certificates.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using namespace std::chrono_literals;

TEST(SelfProbeTest, TellsWhoAnswersFromWhoOnlyListens) {
  const TestServer server;
  EXPECT_TRUE(ProbeListener(*ParseListenAddress(server.server->address()), false, 5s).ok());
  const auto deaf = *BindListenSockets({.host = "127.0.0.1", .port = 0}, "listen");
  const ListenAddress address{.host = "127.0.0.1", .port = deaf.port};
  for (const bool tls : {false, true}) {
    EXPECT_EQ(ProbeListener(address, tls, 100ms).code(), absl::StatusCode::kDeadlineExceeded)
        << "the kernel accepts, nobody else does";
  }
  const ListenAddress nobody{.host = "127.0.0.1", .port = 1};
  EXPECT_EQ(ProbeListener(nobody, false, 1s).code(), absl::StatusCode::kUnavailable);
}

TEST(SelfProbeTest, WildcardsAreReachedByLoopback) {
  ServerConfig config = TestServer::StubConfig();
  const TemporaryFolder folder;
  config.data = folder.path() / "store";
  config.listen = "0.0.0.0:0";
  config.allow_plaintext_off_loopback = true;
  const auto server = *Server::Start(config);
  EXPECT_TRUE(ProbeListener(*ParseListenAddress(server->address()), false, 5s).ok());
}

TEST(SelfProbeTest, TlsAnswersAlsoThoseWithoutACertificate) {
  const TemporaryFolder folder;
  const TestCertificate authority = TestCertificate::Authority("authority");
  authority.Write(folder.path(), "authority");
  TestCertificate::SignedBy(authority, "server").Write(folder.path(), "server");
  ServerConfig config = TestServer::StubConfig();
  config.data = folder.path() / "store";
  config.listen = "127.0.0.1:0";
  config.tls_cert = folder.path() / "server.pem";
  config.tls_key = folder.path() / "server.key";
  config.tls_client_ca = folder.path() / "authority.pem";
  const auto server = *Server::Start(config);
  EXPECT_TRUE(ProbeListener(*ParseListenAddress(server->address()), true, 5s).ok());
}

}  // namespace
}  // namespace dcloc::server
