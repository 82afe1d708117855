#include "server/net/liveness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>
#include <vector>

#include "server/net/listen_sockets.h"
#include "server/net/listener.h"
#include "server/net/self_probe.h"
#include "server/net/service_manager.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/test_certificates.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// systemd's end of the notifications.
class NotifySocket {
 public:
  NotifySocket() : fd_(socket(AF_UNIX, SOCK_DGRAM, 0)) {
    const std::string path = folder_.path() / "notify";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    EXPECT_EQ(bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~NotifySocket() { unsetenv("NOTIFY_SOCKET"); }

  /// What has come by now; empty when nothing has.
  std::string Read() const {
    std::array<char, 256> buffer{};
    const ssize_t size = recv(fd_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : "";
  }

 private:
  const TemporaryFolder folder_;
  const FileDescriptor fd_;
};

TEST(LivenessTest, TwoFailuresCountAndASuccessMends) {
  const NotifySocket systemd;
  bool works = true;
  std::vector<bool> reports;
  Liveness liveness([&] { return works ? absl::OkStatus() : absl::UnavailableError("deaf"); },
                    [&](bool ok) { reports.push_back(ok); });
  liveness.Check();
  EXPECT_EQ(systemd.Read(), "WATCHDOG=1");
  works = false;
  liveness.Check();
  EXPECT_TRUE(liveness.ok()) << "once may be an accident";
  works = true;
  liveness.Check();
  works = false;
  liveness.Check();
  EXPECT_TRUE(liveness.ok()) << "not two in a row";
  EXPECT_EQ(systemd.Read(), "WATCHDOG=1");
  EXPECT_EQ(systemd.Read(), "") << "no word of a failure";
  liveness.Check();
  liveness.Check();
  EXPECT_FALSE(liveness.ok());
  works = true;
  liveness.Check();
  EXPECT_TRUE(liveness.ok());
  EXPECT_THAT(reports, ElementsAre(false, true));
}

TEST(ServiceManagerTest, WithoutOneNothingIsSaid) {
  EXPECT_TRUE(NotifyServiceManager("READY=1"));
  setenv("NOTIFY_SOCKET", "/nowhere/at/all", 1);
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  setenv("NOTIFY_SOCKET", std::string(200, 'x').c_str(), 1);
  EXPECT_FALSE(NotifyServiceManager("READY=1"));
  unsetenv("NOTIFY_SOCKET");
}

TEST(ServiceManagerTest, TheWatchdogIsForThisProcessOnly) {
  EXPECT_FALSE(WatchdogInterval().has_value());
  setenv("WATCHDOG_USEC", "30000000", 1);
  EXPECT_EQ(WatchdogInterval(), 30s);
  setenv("WATCHDOG_PID", "1", 1);
  EXPECT_FALSE(WatchdogInterval().has_value());
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  EXPECT_EQ(WatchdogInterval(), 30s);
  setenv("WATCHDOG_USEC", "often", 1);
  EXPECT_FALSE(WatchdogInterval().has_value());
  unsetenv("WATCHDOG_USEC");
  unsetenv("WATCHDOG_PID");
}

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
