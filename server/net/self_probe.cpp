#include "server/net/self_probe.h"

#include <netdb.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

/// HTTP/2's connection preface, and an empty SETTINGS frame behind it.
constexpr absl::string_view kPreface("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0",
                                     24 + 9);
constexpr std::size_t kFrameHeaderSize = 9;
constexpr char kSettingsFrame = 4;

/// A socket with a deadline; closed at its end.
class Socket {
 public:
  Socket(const addrinfo& target, Clock::time_point deadline)
      : fd_(socket(target.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
        deadline_(deadline) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  int fd() const { return fd_; }

  absl::Status Wait(short events) const {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now());
    pollfd wanted{.fd = fd_, .events = events, .revents = 0};
    const int ready = left.count() > 0 ? poll(&wanted, 1, static_cast<int>(left.count())) : 0;
    if (ready > 0) return absl::OkStatus();
    return ready < 0 ? absl::ErrnoToStatus(errno, "poll")
                     : absl::DeadlineExceededError("the server has not answered in time");
  }

  absl::Status Connect(const addrinfo& target) const {
    if (fd_ < 0) return absl::ErrnoToStatus(errno, "socket");
    if (connect(fd_, target.ai_addr, target.ai_addrlen) == 0) return absl::OkStatus();
    if (errno != EINPROGRESS) return absl::UnavailableError("the connection is refused");
    if (absl::Status status = Wait(POLLOUT); !status.ok()) return status;
    int error = 0;
    socklen_t size = sizeof(error);
    getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &size);
    return error == 0 ? absl::OkStatus() : absl::UnavailableError("the connection is refused");
  }

 private:
  const int fd_;
  const Clock::time_point deadline_;
};

absl::Status ProbePlaintext(const Socket& connection) {
  if (send(connection.fd(), kPreface.data(), kPreface.size(), MSG_NOSIGNAL) !=
      static_cast<ssize_t>(kPreface.size())) {
    return absl::UnavailableError("the connection takes nothing");
  }
  std::array<char, kFrameHeaderSize> frame{};
  for (std::size_t size = 0; size < frame.size();) {
    if (absl::Status status = connection.Wait(POLLIN); !status.ok()) return status;
    const ssize_t got = recv(connection.fd(), frame.data() + size, frame.size() - size, 0);
    if (got <= 0) return absl::UnavailableError("the server closed the connection");
    size += static_cast<std::size_t>(got);
  }
  // The type, behind three bytes of length.
  return frame[3] == kSettingsFrame ? absl::OkStatus()
                                    : absl::UnavailableError("the server speaks, but not HTTP/2");
}

absl::Status ProbeTls(const Socket& connection) {
  ERR_clear_error();
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context(SSL_CTX_new(TLS_client_method()),
                                                                  &SSL_CTX_free);
  const std::unique_ptr<SSL, decltype(&SSL_free)> ssl(SSL_new(context.get()), &SSL_free);
  // Whose certificate it is does not matter: nothing is said over it.
  SSL_set_verify(ssl.get(), SSL_VERIFY_NONE, nullptr);
  SSL_set_fd(ssl.get(), connection.fd());
  while (true) {
    const int result = SSL_connect(ssl.get());
    const int error = SSL_get_error(ssl.get(), result);
    absl::Status status;
    if (error == SSL_ERROR_WANT_READ) {
      status = connection.Wait(POLLIN);
    } else if (error == SSL_ERROR_WANT_WRITE) {
      status = connection.Wait(POLLOUT);
    } else {
      ERR_clear_error();
      // Also a server that wants a certificate has answered.
      if (result == 1 || error == SSL_ERROR_SSL) return absl::OkStatus();
      return absl::UnavailableError("the server closed the connection");
    }
    if (!status.ok()) return status;
  }
}

std::string ReachableHost(const ListenAddress& address) {
  if (address.host == "0.0.0.0") return "127.0.0.1";
  if (address.host == "::") return "::1";
  return address.host;
}

}  // namespace

absl::Status ProbeListener(const ListenAddress& address, bool tls,
                           std::chrono::milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  const std::string host = ReachableHost(address);
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(host.c_str(), absl::StrCat(address.port).c_str(), &hints, &found);
  if (error != 0) return absl::UnavailableError(absl::StrCat(host, ": ", gai_strerror(error)));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> targets(found, &freeaddrinfo);
  absl::Status status;
  for (const addrinfo* target = found; target != nullptr; target = target->ai_next) {
    const Socket connection(*target, deadline);
    status = connection.Connect(*target);
    if (!status.ok()) continue;
    return tls ? ProbeTls(connection) : ProbePlaintext(connection);
  }
  return status;
}

}  // namespace dcloc::server
