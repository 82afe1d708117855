#include "server/net/listener.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

#include "server/net/listen_sockets.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kOtherFilesShare = 8;
constexpr int kMinOtherFiles = 32;
constexpr std::chrono::milliseconds kRetryDelay(10);

}  // namespace

int Listener::MaxDescriptor() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const int max = static_cast<int>(std::min<rlim_t>(limit.rlim_cur, 1 << 30));
  return max - std::max(kMinOtherFiles, max / kOtherFilesShare);
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::Bind(const ListenAddress& address,
                                                         int max_descriptor) {
  absl::StatusOr<ListenSockets> listening = BindListenSockets(address, "listen");
  if (!listening.ok()) return listening.status();
  FileDescriptor wake(eventfd(0, EFD_CLOEXEC));
  if (wake.get() < 0) return absl::ErrnoToStatus(errno, "eventfd");
  return std::unique_ptr<Listener>(new Listener(std::move(listening->sockets), std::move(wake),
                                                listening->port, max_descriptor));
}

Listener::Listener(std::vector<FileDescriptor> sockets, FileDescriptor wake, int port,
                   int max_descriptor)
    : sockets_(std::move(sockets)),
      wake_(std::move(wake)),
      port_(port),
      max_descriptor_(max_descriptor) {}

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
      if (wanted[i].revents != 0) Accept(wanted[i].fd);
    }
  }
}

void Listener::Accept(int socket_fd) {
  const int fd = accept4(socket_fd, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (fd < 0) {
    // Out of descriptors, below the cap: files have taken them. It will pass.
    if (errno == EMFILE || errno == ENFILE) std::this_thread::sleep_for(kRetryDelay);
    return;
  }
  // A new descriptor is the lowest that is free, so as many as its number are open.
  if (fd >= max_descriptor_) {
    close(fd);
    ++refused_count_;
    spdlog::warn("connection refused open_files={} max={}", fd, max_descriptor_);
    return;
  }
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
  connection.listener_fd = socket_fd;
  connection.fd = fd;
  acceptor_->HandleNewConnection(&connection);
}

}  // namespace dcloc::server
