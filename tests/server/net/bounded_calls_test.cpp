#include "server/net/bounded_calls.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "tests/server/fixtures/silent_call.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

TEST(BoundedCallsTest, ReflectionEndsAndHasFewThreads) {
  ServerConfig config = TestServer::StubConfig();
  config.open_timeout_ms = 1500;
  const TestServer server(config);
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::unique_ptr<SilentCall>> calls;
  calls.reserve(40);
  for (int i = 0; i < 40; ++i) {
    calls.push_back(std::make_unique<SilentCall>(
        server, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"));
  }
  int cancelled = 0;
  int refused = 0;
  for (const auto& call : calls) {
    const grpc::StatusCode code = call->End().error_code();
    cancelled += code == grpc::StatusCode::CANCELLED ? 1 : 0;
    refused += code == grpc::StatusCode::RESOURCE_EXHAUSTED ? 1 : 0;
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  EXPECT_GT(cancelled, 0) << "their time was over";
  EXPECT_GT(refused, 0) << "each holds a thread";
  EXPECT_EQ(cancelled + refused, 40);
}

/// HTTP/2 by hand: a peer that takes no byte of an answer (SETTINGS_INITIAL_WINDOW_SIZE 0).
class WindowlessPeer {
 public:
  explicit WindowlessPeer(const std::string& address)
      : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port =
        htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_.get(), reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0);
    timeval patience{.tv_sec = 20, .tv_usec = 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    Send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Frame(4, 0, 0, std::string("\0\4\0\0\0\0", 6)));
  }

  /// Begins a call, on stream 1, with an empty request.
  void Ask(const std::string& path) {
    std::string block;
    for (const auto& [name, value] : {std::pair<std::string, std::string>{":method", "POST"},
                                      {":scheme", "http"},
                                      {":path", path},
                                      {":authority", "x"},
                                      {"content-type", "application/grpc"},
                                      {"te", "trailers"}}) {
      absl::StrAppend(&block, std::string(1, '\0'), Text(name), Text(value));
    }
    Send(Frame(1, 4, 1, block) + Frame(0, 1, 1, std::string(5, '\0')));
  }

  /// Whether a reset, or the end, of stream 1 comes before the patience ends.
  bool SeesItEnd() {
    std::string bytes;
    char buffer[4096];
    for (ssize_t size = 0; (size = recv(socket_.get(), buffer, sizeof(buffer), 0)) > 0;) {
      bytes.append(buffer, static_cast<std::size_t>(size));
      for (std::size_t at = 0; at + 9 <= bytes.size();) {
        const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[at + i]); };
        const bool is_reset = byte(3) == 3;
        const bool ends = byte(3) <= 1 && (byte(4) & 1U) != 0;
        if (byte(8) == 1 && (is_reset || ends)) return true;
        at += 9 + (std::size_t{byte(0)} << 16 | std::size_t{byte(1)} << 8 | byte(2));
      }
    }
    return false;
  }

 private:
  static std::string Text(const std::string& text) {
    return std::string(1, static_cast<char>(text.size())) + text;
  }

  static std::string Frame(char type, char flags, char stream, const std::string& payload) {
    std::string frame(9, '\0');
    frame[1] = static_cast<char>(payload.size() >> 8);
    frame[2] = static_cast<char>(payload.size());
    frame[3] = type;
    frame[4] = flags;
    frame[8] = stream;
    return frame + payload;
  }

  void Send(const std::string& bytes) {
    EXPECT_EQ(send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }

  FileDescriptor socket_;
};

TEST(BoundedCallsTest, AnAnswerThatIsNotReadIsLetGo) {
  ServerConfig config = TestServer::StubConfig();
  config.peer_timeout_ms = 1000;
  const TestServer server(config);
  for (const char* path :
       {"/dcloc.v1.AdminService/GetServerState", "/grpc.health.v1.Health/Check"}) {
    WindowlessPeer peer(server.server->address());
    const auto begin = std::chrono::steady_clock::now();
    peer.Ask(path);
    EXPECT_TRUE(peer.SeesItEnd()) << path;
    EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(900)) << path;
  }
}

}  // namespace
}  // namespace dcloc::server
