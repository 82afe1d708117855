#include "server/net/liveness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <vector>

#include "server/base/files.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

using ::testing::ElementsAre;

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

}  // namespace
}  // namespace dcloc::server
