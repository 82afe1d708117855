#include "server/telemetry/metrics_endpoint.h"

#include <poll.h>
#include <prometheus/text_serializer.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kMaxTime(1);
constexpr std::size_t kMaxRequest_bytes = 8192;
constexpr absl::string_view kEndOfHeaders = "\r\n\r\n";

/// False when `events` do not come before `deadline`.
bool WaitFor(int fd, short events, Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
  pollfd wanted{.fd = fd, .events = events, .revents = 0};
  return left.count() > 0 && poll(&wanted, 1, static_cast<int>(left.count())) > 0;
}

/// The request's line and headers; what there is of them when no more comes.
std::string ReadRequest(int fd, Clock::time_point deadline) {
  std::string request;
  std::array<char, 1024> buffer{};
  while (request.size() < kMaxRequest_bytes && !absl::StrContains(request, kEndOfHeaders) &&
         WaitFor(fd, POLLIN, deadline)) {
    const ssize_t size = recv(fd, buffer.data(), buffer.size(), 0);
    if (size <= 0) break;
    request.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return request;
}

void Send(int fd, absl::string_view text, Clock::time_point deadline) {
  while (!text.empty() && WaitFor(fd, POLLOUT, deadline)) {
    const ssize_t size = send(fd, text.data(), text.size(), MSG_NOSIGNAL);
    if (size <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(size));
  }
}

std::string Response(absl::string_view status, absl::string_view body) {
  return absl::StrCat("HTTP/1.1 ", status,
                      "\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8"
                      "\r\nConnection: close\r\nContent-Length: ",
                      body.size(), kEndOfHeaders, body);
}

}  // namespace

absl::StatusOr<ListenAddress> ParseMetricsAddress(absl::string_view text) {
  const bool is_port = !absl::StrContains(text, ":");
  absl::StatusOr<ListenAddress> address =
      ParseListenAddress(is_port ? absl::StrCat("127.0.0.1:", text) : std::string(text));
  if (address.ok()) return address;
  return absl::InvalidArgumentError(
      absl::StrCat("metrics_listen is ", Quoted(text),
                   "; it must be HOST:PORT, or a PORT of 127.0.0.1, in [0, 65535]"));
}

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::Start(
    const ListenAddress& address,
    std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
    std::function<absl::Status()> ready) {
  absl::StatusOr<ListenSockets> listening = BindListenSockets(address, "metrics_listen");
  if (!listening.ok()) return listening.status();
  FileDescriptor wake(eventfd(0, EFD_CLOEXEC));
  if (wake.get() < 0) return absl::ErrnoToStatus(errno, "eventfd");
  ListenAddress bound = address;
  bound.port = listening->port;
  return std::unique_ptr<MetricsEndpoint>(
      new MetricsEndpoint(*std::move(listening), std::move(wake), bound.ToString(),
                          std::move(collectables), std::move(ready)));
}

MetricsEndpoint::MetricsEndpoint(ListenSockets listening, FileDescriptor wake, std::string address,
                                 std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
                                 std::function<absl::Status()> ready)
    : listening_(std::move(listening)),
      wake_(std::move(wake)),
      address_(std::move(address)),
      collectables_(std::move(collectables)),
      ready_(std::move(ready)),
      thread_([this] { Run(); }) {}

MetricsEndpoint::~MetricsEndpoint() {
  eventfd_write(wake_.get(), 1);
  thread_.join();
}

void MetricsEndpoint::Run() const {
  std::vector<pollfd> wanted = {{.fd = wake_.get(), .events = POLLIN, .revents = 0}};
  for (const FileDescriptor& socket : listening_.sockets) {
    wanted.push_back({.fd = socket.get(), .events = POLLIN, .revents = 0});
  }
  while (true) {
    if (poll(wanted.data(), wanted.size(), -1) < 0) continue;
    if (wanted[0].revents != 0) return;
    for (std::size_t i = 1; i < wanted.size(); ++i) {
      if (wanted[i].revents != 0) Serve(wanted[i].fd);
    }
  }
}

void MetricsEndpoint::Serve(int listening_fd) const {
  const FileDescriptor connection(
      accept4(listening_fd, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (connection.get() < 0) return;
  const std::string request = ReadRequest(connection.get(), Clock::now() + kMaxTime);
  Send(connection.get(), Respond(request), Clock::now() + kMaxTime);
  shutdown(connection.get(), SHUT_WR);
}

std::string MetricsEndpoint::Respond(absl::string_view request) const {
  if (!absl::StrContains(request, kEndOfHeaders)) return Response("400 Bad Request", "");
  if (!absl::StartsWith(request, "GET ")) return Response("405 Method Not Allowed", "");
  const absl::string_view target = request.substr(4, request.find_first_of(" ?\r", 4) - 4);
  if (target == "/ready") {
    const absl::Status status = ready_();
    return status.ok() ? Response("200 OK", "ready\n")
                       : Response("503 Service Unavailable", absl::StrCat(status.message(), "\n"));
  }
  if (target != "/metrics") return Response("404 Not Found", "metrics are at /metrics\n");
  std::vector<prometheus::MetricFamily> families;
  for (const auto& collectable : collectables_) {
    for (prometheus::MetricFamily& family : collectable->Collect()) {
      families.push_back(std::move(family));
    }
  }
  return Response("200 OK", prometheus::TextSerializer().Serialize(families));
}

}  // namespace dcloc::server
