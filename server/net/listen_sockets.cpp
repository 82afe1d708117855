#include "server/net/listen_sockets.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/status.h"

namespace dcloc::server {
namespace {

constexpr int kBacklog = 4096;

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

int PortOf(int fd) {
  sockaddr_storage bound{};
  socklen_t size = sizeof(bound);
  getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size);
  return ntohs(bound.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port
                                           : reinterpret_cast<sockaddr_in*>(&bound)->sin_port);
}

/// -1 inside when the address cannot be had; errno then says why.
FileDescriptor ListenOn(const addrinfo& target, int port) {
  FileDescriptor listening(socket(target.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  setsockopt(listening.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
  sockaddr_storage address{};
  std::copy_n(reinterpret_cast<const char*>(target.ai_addr), target.ai_addrlen,
              reinterpret_cast<char*>(&address));
  // A free port is taken once, and is the same for all of a host's addresses.
  if (target.ai_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6*>(&address)->sin6_port = htons(static_cast<std::uint16_t>(port));
  } else {
    reinterpret_cast<sockaddr_in*>(&address)->sin_port = htons(static_cast<std::uint16_t>(port));
  }
  const bool listens =
      bind(listening.get(), reinterpret_cast<const sockaddr*>(&address), target.ai_addrlen) == 0 &&
      listen(listening.get(), kBacklog) == 0;
  const int error = errno;
  if (!listens) listening = FileDescriptor();
  errno = error;
  return listening;
}

}  // namespace

absl::StatusOr<ListenSockets> BindListenSockets(const ListenAddress& address,
                                                absl::string_view setting) {
  const absl::Status failed = absl::UnavailableError(absl::StrCat(
      setting, " is ", Quoted(address.ToString()), "; the address cannot be listened on"));
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  if (getaddrinfo(address.host.c_str(), absl::StrCat(address.port).c_str(), &hints, &found) != 0) {
    return failed;
  }
  const Addresses targets(found, &freeaddrinfo);
  ListenSockets bound{.sockets = {}, .port = address.port};
  for (const addrinfo* target = found; target != nullptr; target = target->ai_next) {
    FileDescriptor listening = ListenOn(*target, bound.port);
    // A name may have an address that this machine has not, such as ::1 where there is no IPv6.
    if (listening.get() < 0 && errno == EADDRINUSE) return failed;
    if (listening.get() < 0) continue;
    bound.port = PortOf(listening.get());
    bound.sockets.push_back(std::move(listening));
  }
  if (bound.sockets.empty()) return failed;
  return bound;
}

}  // namespace dcloc::server
