#include "server/net/self_probe.h"

#include <netdb.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "server/net/health_question.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;

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

absl::Status Closed() { return absl::UnavailableError("the server closed the connection"); }

class PlaintextBytes : public ProbeBytes {
 public:
  explicit PlaintextBytes(const Socket& connection) : connection_(connection) {}

  absl::Status Write(absl::string_view bytes) override {
    // A new connection takes so little at once.
    const ssize_t sent = send(connection_.fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return sent == static_cast<ssize_t>(bytes.size())
               ? absl::OkStatus()
               : absl::UnavailableError("the connection takes nothing");
  }

  absl::Status Read(absl::Span<char> bytes) override {
    while (!bytes.empty()) {
      if (absl::Status status = connection_.Wait(POLLIN); !status.ok()) return status;
      const ssize_t got = recv(connection_.fd(), bytes.data(), bytes.size(), 0);
      if (got <= 0) return Closed();
      bytes.remove_prefix(static_cast<std::size_t>(got));
    }
    return absl::OkStatus();
  }

 private:
  const Socket& connection_;
};

class TlsBytes : public ProbeBytes {
 public:
  explicit TlsBytes(const Socket& connection)
      : connection_(connection),
        context_(SSL_CTX_new(TLS_client_method()), &SSL_CTX_free),
        ssl_(SSL_new(context_.get()), &SSL_free) {
    // Whose certificate it is does not matter: nothing that counts is said over it.
    SSL_set_verify(ssl_.get(), SSL_VERIFY_NONE, nullptr);
    static constexpr unsigned char kHttp2[] = {2, 'h', '2'};
    SSL_set_alpn_protos(ssl_.get(), kHttp2, sizeof(kHttp2));
    SSL_set_fd(ssl_.get(), connection.fd());
  }

  absl::Status Handshake() {
    return Repeat([this] { return SSL_connect(ssl_.get()); });
  }

  absl::Status Write(absl::string_view bytes) override {
    return Repeat(
        [&] { return SSL_write(ssl_.get(), bytes.data(), static_cast<int>(bytes.size())); });
  }

  absl::Status Read(absl::Span<char> bytes) override {
    while (!bytes.empty()) {
      int got = 0;
      absl::Status status = Repeat(
          [&] { return got = SSL_read(ssl_.get(), bytes.data(), static_cast<int>(bytes.size())); });
      if (!status.ok()) return status;
      bytes.remove_prefix(static_cast<std::size_t>(got));
    }
    return absl::OkStatus();
  }

  /// Whether the server has refused us by TLS's own means, as one does that wants a certificate.
  bool refused() const { return refused_; }

 private:
  template <typename Step>
  absl::Status Repeat(Step step) {
    while (true) {
      ERR_clear_error();
      const int result = step();
      if (result > 0) return absl::OkStatus();
      const int error = SSL_get_error(ssl_.get(), result);
      absl::Status status;
      if (error == SSL_ERROR_WANT_READ) {
        status = connection_.Wait(POLLIN);
      } else if (error == SSL_ERROR_WANT_WRITE) {
        status = connection_.Wait(POLLOUT);
      } else {
        ERR_clear_error();
        refused_ = error == SSL_ERROR_SSL;
        status = Closed();
      }
      if (!status.ok()) return status;
    }
  }

  const Socket& connection_;
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context_;
  const std::unique_ptr<SSL, decltype(&SSL_free)> ssl_;
  bool refused_ = false;
};

absl::Status ProbePlaintext(const Socket& connection) {
  PlaintextBytes bytes(connection);
  return AskHealth(bytes);
}

absl::Status ProbeTls(const Socket& connection) {
  TlsBytes bytes(connection);
  absl::Status status = bytes.Handshake();
  if (bytes.refused()) return absl::OkStatus();
  if (!status.ok()) return status;
  status = AskHealth(bytes);
  // A server that wants a certificate may end the connection behind the handshake.
  return absl::IsDeadlineExceeded(status) ? status : absl::OkStatus();
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
