#include "server/net/listener.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <utility>

#include "server/base/within_memory.h"
#include "server/net/listen_sockets.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kOtherFilesShare = 8;
constexpr int kMinOtherFiles = 32;
constexpr std::chrono::milliseconds kRetryDelay(10);

/// An address without its port.
std::string TextOf(const sockaddr_storage& address, socklen_t size) {
  std::array<char, NI_MAXHOST> text{};
  const int error = getnameinfo(reinterpret_cast<const sockaddr*>(&address), size, text.data(),
                                text.size(), nullptr, 0, NI_NUMERICHOST);
  return error == 0 ? text.data() : "unknown";
}

}  // namespace

int Listener::MaxDescriptor() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const int max = static_cast<int>(std::min<rlim_t>(limit.rlim_cur, 1 << 30));
  return max - std::max(kMinOtherFiles, max / kOtherFilesShare);
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::Bind(const ListenAddress& address,
                                                         const Bounds& bounds) {
  absl::StatusOr<ListenSockets> listening = BindListenSockets(address, "listen");
  if (!listening.ok()) return listening.status();
  FileDescriptor wake(eventfd(0, EFD_CLOEXEC));
  if (wake.get() < 0) return absl::ErrnoToStatus(errno, "eventfd");
  return std::unique_ptr<Listener>(
      new Listener(std::move(listening->sockets), std::move(wake), listening->port, bounds));
}

Listener::Listener(std::vector<FileDescriptor> sockets, FileDescriptor wake, int port,
                   const Bounds& bounds)
    : sockets_(std::move(sockets)),
      wake_(std::move(wake)),
      port_(port),
      max_descriptor_(bounds.max_descriptor),
      peers_(bounds.max_count_per_peer) {}

void Listener::Start(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor) {
  acceptor_ = std::move(acceptor);
  thread_ = std::thread([this] { Run(); });
}

void Listener::Stop() {
  if (thread_.joinable()) {
    eventfd_write(wake_.get(), 1);
    thread_.join();
  }
  sockets_.clear();
}

void Listener::Run() {
  std::vector<pollfd> wanted = {{.fd = wake_.get(), .events = POLLIN, .revents = 0}};
  for (const FileDescriptor& listening : sockets_) {
    wanted.push_back({.fd = listening.get(), .events = POLLIN, .revents = 0});
  }
  while (true) {
    if (poll(wanted.data(), wanted.size(), -1) < 0) continue;
    if (wanted[0].revents != 0) return;
    for (std::size_t i = 1; i < wanted.size(); ++i) {
      if (wanted[i].revents != 0) WithinMemory([&] { Accept(wanted[i].fd); }).IgnoreError();
    }
  }
}

bool Listener::MayStay(int fd, const std::string& peer) {
  // A new descriptor is the lowest that is free, so as many as its number are open.
  if (fd >= max_descriptor_) {
    spdlog::warn("connection refused open_files={} max={}", fd, max_descriptor_);
    return false;
  }
  if (peers_.Add(peer, fd)) return true;
  spdlog::warn("connection refused peer={} reason=\"it has too many\"", peer);
  return false;
}

void Listener::Accept(int socket_fd) {
  sockaddr_storage peer{};
  socklen_t size = sizeof(peer);
  FileDescriptor accepted(
      accept4(socket_fd, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
  const int fd = accepted.get();
  if (fd < 0) {
    // Out of descriptors, below the cap: files have taken them. It will pass.
    if (errno == EMFILE || errno == ENFILE) std::this_thread::sleep_for(kRetryDelay);
    return;
  }
  if (!MayStay(fd, TextOf(peer, size))) {
    ++refused_count_;
    return;
  }
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
  connection.listener_fd = socket_fd;
  connection.fd = accepted.Release();
  acceptor_->HandleNewConnection(&connection);
}

}  // namespace dcloc::server
