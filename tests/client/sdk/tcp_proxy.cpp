#include "tests/client/sdk/tcp_proxy.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace dcloc::client {
namespace {

constexpr int kPoll_ms = 20;

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  return address;
}

bool IsReadable(int socket) {
  pollfd entry{.fd = socket, .events = POLLIN, .revents = 0};
  return poll(&entry, 1, kPoll_ms) > 0;
}

bool SendAll(int socket, const char* data, ssize_t size) {
  while (size > 0) {
    const ssize_t sent = send(socket, data, static_cast<std::size_t>(size), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    data += sent;
    size -= sent;
  }
  return true;
}

/// Carries what is there from one to the other; false when there will be no more.
bool Forward(int from, int to) {
  std::array<char, 16384> buffer{};
  const ssize_t received = recv(from, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (received < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
  return received > 0 && SendAll(to, buffer.data(), received);
}

/// Closes with a reset: the peer hears nothing of what was still on its way.
void Reset(int socket) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  close(socket);
}

}  // namespace

TcpProxy::TcpProxy(int port) : target_(port) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof(address);
  if (bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      listen(listener_, 64) != 0 ||
      getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    throw std::runtime_error("no port for the proxy");
  }
  port_ = ntohs(address.sin_port);
  acceptor_ = std::thread([this] { Accept(); });
}

TcpProxy::~TcpProxy() {
  stopping_ = true;
  acceptor_.join();
  Cut();
  for (std::thread& carrier : carriers_) carrier.join();
  close(listener_);
}

void TcpProxy::Cut() {
  const std::lock_guard lock(mutex_);
  for (const int socket : open_) shutdown(socket, SHUT_RDWR);
}

void TcpProxy::Accept() {
  while (!stopping_) {
    if (!IsReadable(listener_)) continue;
    // A program that is started meanwhile must not hold it open.
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
    if (client < 0) continue;
    ++connection_count_;
    carriers_.emplace_back([this, client] { Carry(client); });
  }
}

void TcpProxy::Carry(int client) {
  const int server = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = Loopback(target_);
  bool open = connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  {
    const std::lock_guard lock(mutex_);
    open_.push_back(client);
    open_.push_back(server);
  }
  std::array<pollfd, 2> ends{pollfd{.fd = client, .events = POLLIN, .revents = 0},
                             pollfd{.fd = server, .events = POLLIN, .revents = 0}};
  while (open && !stopping_) {
    if (poll(ends.data(), ends.size(), kPoll_ms) <= 0) continue;
    if (ends[0].revents != 0) open = Forward(client, server);
    if (open && ends[1].revents != 0) open = Forward(server, client);
  }
  const std::lock_guard lock(mutex_);
  std::erase(open_, client);
  std::erase(open_, server);
  Reset(client);
  Reset(server);
}

}  // namespace dcloc::client
