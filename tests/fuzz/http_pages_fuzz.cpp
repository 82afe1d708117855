#include "server/telemetry/http_pages.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>

#include "absl/strings/match.h"
#include "tests/fuzz/fuzz_target.h"

namespace dcloc {
namespace {

/// The port of pages as a server has them. They live as long as the process.
std::uint16_t Port() {
  static server::HttpPages* const pages =
      server::HttpPages::Serve(
          {.host = "127.0.0.1", .port = 0}, "metrics_listen",
          {{.path = "/metrics", .make = [] { return server::HttpAnswer{.body = "up 1\n"}; }},
           {.path = "/ready",
            .make = [] { return server::HttpAnswer{.body = "ready\n"}; },
            .is_urgent = true}})
          ->release();
  return static_cast<std::uint16_t>(
      std::atoi(pages->address().substr(pages->address().rfind(':') + 1).c_str()));
}

/// A connection that leaves nothing behind when it is closed.
int Connect() {
  const int connection = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  setsockopt(connection, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(Port());
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int status = connect(connection, reinterpret_cast<sockaddr*>(&address), sizeof(address));
  Require(status == 0, "the pages take connections");
  return connection;
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  return {InputOf("GET /metrics HTTP/1.1\r\nHost: localhost:9464\r\nAccept: */*\r\n\r\n"),
          InputOf("GET /ready?verbose HTTP/1.0\r\n\r\n"), InputOf("POST /metrics HTTP/1.1\r\n\r\n"),
          InputOf("GET / HTTP/1.1\r\nX: " + std::string(300, 'x') + "\r\n\r\n")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const int connection = dcloc::Connect();
  // It may have answered, and closed, before all of a long one is sent.
  send(connection, data, size, MSG_NOSIGNAL);
  shutdown(connection, SHUT_WR);
  std::string answer;
  std::array<char, 4096> buffer;
  ssize_t got = 0;
  while ((got = recv(connection, buffer.data(), buffer.size(), 0)) > 0) {
    answer.append(buffer.data(), static_cast<std::size_t>(got));
  }
  close(connection);
  dcloc::Require(got < 0 || absl::StartsWith(answer, "HTTP/1.1 "), "each request is answered");
  return 0;
}
