#include "client/load/relay.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::load {
namespace {

constexpr int kBacklog = 16;

/// A listening socket on a free port of loopback.
absl::StatusOr<std::pair<int, int>> Listen() {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  auto* any = reinterpret_cast<sockaddr*>(&address);
  if (listener >= 0 && bind(listener, any, size) == 0 && listen(listener, kBacklog) == 0 &&
      getsockname(listener, any, &size) == 0) {
    return std::pair(listener, int{ntohs(address.sin_port)});
  }
  const int error = errno;
  if (listener >= 0) close(listener);
  return absl::ErrnoToStatus(error, "no port for a connection that is to be broken");
}

/// Carries what is there; false when there will be no more.
bool Forward(int from, int to) {
  std::array<char, 16384> buffer;
  const ssize_t received = recv(from, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (received < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  for (ssize_t sent = 0; sent < received;) {
    const ssize_t size =
        send(to, buffer.data() + sent, static_cast<std::size_t>(received - sent), MSG_NOSIGNAL);
    if (size <= 0) return false;
    sent += size;
  }
  return received > 0;
}

/// Closes with a reset: the peer hears nothing of what was still on its way.
void Reset(int socket) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  close(socket);
}

void SendAtOnce(int socket) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Relay>> Relay::Start(const std::string& server) {
  const std::size_t colon = server.rfind(':');
  std::string host = server.substr(0, colon);
  if (host.size() >= 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const std::string port = colon == std::string::npos ? "" : server.substr(colon + 1);
  const int error = getaddrinfo(host.c_str(), port.c_str(), &wanted, &found);
  if (error != 0) return absl::UnavailableError(absl::StrCat(server, ": ", gai_strerror(error)));
  Addresses addresses(found, &freeaddrinfo);
  const auto listening = Listen();
  if (!listening.ok()) return listening.status();
  const int wake = eventfd(0, EFD_CLOEXEC);
  if (wake < 0) {
    close(listening->first);
    return absl::ErrnoToStatus(errno, "eventfd");
  }
  return std::unique_ptr<Relay>(
      new Relay(std::move(addresses), listening->first, listening->second, wake));
}

Relay::Relay(Addresses server, int listener, int port, int wake)
    : server_(std::move(server)), listener_(listener), port_(port), wake_(wake), thread_([this] {
        Run();
      }) {}

Relay::~Relay() {
  stopping_ = true;
  eventfd_write(wake_, 1);
  Cut();  // it may be waiting to send
  thread_.join();
  for (const Link& link : links_) {
    Reset(link.client);
    Reset(link.server);
  }
  close(listener_);
  close(wake_);
}

std::string Relay::address() const { return absl::StrCat("127.0.0.1:", port_); }

void Relay::Cut() {
  const std::lock_guard lock(mutex_);
  for (const Link& link : links_) {
    shutdown(link.client, SHUT_RDWR);
    shutdown(link.server, SHUT_RDWR);
  }
}

void Relay::Run() {
  while (!stopping_) {
    std::vector<pollfd> wanted = {{.fd = wake_, .events = POLLIN, .revents = 0},
                                  {.fd = listener_, .events = POLLIN, .revents = 0}};
    for (const Link& link : links_) {
      wanted.push_back({.fd = link.client, .events = POLLIN, .revents = 0});
      wanted.push_back({.fd = link.server, .events = POLLIN, .revents = 0});
    }
    if (poll(wanted.data(), wanted.size(), -1) <= 0) continue;
    // From behind, so that those before keep their places when one goes.
    for (std::size_t i = links_.size(); i-- > 0;) {
      Carry(i, wanted[2 + 2 * i].revents, wanted[3 + 2 * i].revents);
    }
    if (wanted[1].revents != 0) Accept();
  }
}

void Relay::Accept() {
  const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  const int server = Connect();
  if (server < 0) return Reset(client);
  SendAtOnce(client);
  SendAtOnce(server);
  const std::lock_guard lock(mutex_);
  links_.push_back({.client = client, .server = server});
}

void Relay::Carry(std::size_t index, short client_events, short server_events) {
  const Link link = links_[index];
  if ((client_events == 0 || Forward(link.client, link.server)) &&
      (server_events == 0 || Forward(link.server, link.client))) {
    return;
  }
  const std::lock_guard lock(mutex_);
  links_.erase(links_.begin() + static_cast<std::ptrdiff_t>(index));
  Reset(link.client);
  Reset(link.server);
}

int Relay::Connect() const {
  for (const addrinfo* address = server_.get(); address != nullptr; address = address->ai_next) {
    const int server = socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (server < 0) continue;
    if (connect(server, address->ai_addr, address->ai_addrlen) == 0) return server;
    close(server);
  }
  return -1;
}

}  // namespace dcloc::load
