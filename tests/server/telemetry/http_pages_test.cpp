#include "server/telemetry/http_pages.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class HttpPagesTest : public ::testing::Test {
 protected:
  HttpPagesTest()
      : pages_(*HttpPages::Serve({.host = "127.0.0.1", .port = 0}, "metrics_listen",
                                 {{.path = "/slow",
                                   .make =
                                       [] {
                                         std::this_thread::sleep_for(std::chrono::milliseconds(50));
                                         return HttpAnswer{.body = std::string(8 << 20, 'x')};
                                       }},
                                  {.path = "/quick",
                                   .make = [] { return HttpAnswer{.body = "yes"}; },
                                   .is_urgent = true}})) {}

  FileDescriptor Connect() const {
    FileDescriptor connection(socket(AF_INET, SOCK_STREAM, 0));
    const std::string& address = pages_->address();
    sockaddr_in target{};
    target.sin_family = AF_INET;
    target.sin_port =
        htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    inet_pton(AF_INET, "127.0.0.1", &target.sin_addr);
    EXPECT_EQ(connect(connection.get(), reinterpret_cast<const sockaddr*>(&target), sizeof(target)),
              0);
    return connection;
  }

  static void Say(const FileDescriptor& connection, const std::string& text) {
    send(connection.get(), text.data(), text.size(), MSG_NOSIGNAL);
  }

  static std::string ReadAll(const FileDescriptor& connection) {
    std::string text;
    std::array<char, 4096> buffer{};
    for (ssize_t size = 0; (size = recv(connection.get(), buffer.data(), buffer.size(), 0)) > 0;) {
      text.append(buffer.data(), static_cast<std::size_t>(size));
    }
    return text;
  }

  void ExpectQuick() const {
    const auto begin = Clock::now();
    const FileDescriptor connection = Connect();
    Say(connection, "GET /quick HTTP/1.1\r\n\r\n");
    EXPECT_THAT(ReadAll(connection), AllOf(HasSubstr("200 OK"), HasSubstr("yes")));
    EXPECT_LT(Clock::now() - begin, std::chrono::milliseconds(500));
  }

  std::unique_ptr<HttpPages> pages_;
};

TEST_F(HttpPagesTest, SilentPeersHoldUpNobodyHoweverMany) {
  std::vector<FileDescriptor> silent;
  for (int i = 0; i < 600; ++i) silent.push_back(Connect());
  ExpectQuick();
}

TEST_F(HttpPagesTest, PeersThatDoNotReadHoldUpNobody) {
  std::vector<FileDescriptor> stuck;
  for (int i = 0; i < 5; ++i) {
    stuck.push_back(Connect());
    Say(stuck.back(), "GET /slow HTTP/1.1\r\n\r\n");
  }
  ExpectQuick();
}

TEST_F(HttpPagesTest, ASlowPeerHasASecond) {
  const FileDescriptor slow = Connect();
  Say(slow, "GET /quick");
  EXPECT_THAT(ReadAll(slow), HasSubstr(" 400 "));
}

TEST_F(HttpPagesTest, ARequestMayComeInParts) {
  const FileDescriptor slow = Connect();
  Say(slow, "GET /quick HTTP/1.1\r\n");
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  Say(slow, "\r\n");
  EXPECT_THAT(ReadAll(slow), HasSubstr("200 OK"));
}

}  // namespace
}  // namespace dcloc::server
