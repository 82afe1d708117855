#pragma once

#include <grpcpp/server_builder.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "server/base/files.h"
#include "server/net/listen_address.h"
#include "server/net/peer_connections.h"

namespace dcloc::server {

/// Accepts connections and hands them to gRPC. On its own, gRPC accepts until the process has no
/// file descriptor left, and then never again (CVE-2023-4785). Here a connection beyond the cap is
/// closed at once, and existing calls go on.
class Listener {
 public:
  struct Bounds {
    int max_descriptor = 0;      ///< a connection with this file descriptor or above is closed
    int max_count_per_peer = 0;  ///< so is one beyond so many of its address; > 0
  };

  /// Binds every address that the host has; port 0 takes a free one. Unavailable says which
  /// address.
  static absl::StatusOr<std::unique_ptr<Listener>> Bind(const ListenAddress& address,
                                                        const Bounds& bounds);
  ~Listener() { Stop(); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }

  /// Accepts from now on. The server of `acceptor` has been started, and is shut down after `Stop`.
  void Start(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor);

  /// Takes no more connections. May be called again.
  void Stop();

  /// Connections that were closed at once.
  std::int64_t refused_count() const { return refused_count_; }

  /// Leaves an eighth of the process' file descriptors to files, at least 32.
  static int MaxDescriptor();

 private:
  Listener(std::vector<FileDescriptor> sockets, FileDescriptor wake, int port,
           const Bounds& bounds);
  void Run();
  void Accept(int socket_fd);
  bool MayStay(int fd, const std::string& peer);

  std::vector<FileDescriptor> sockets_;
  FileDescriptor wake_;  ///< readable once it is to stop
  const int port_;
  const int max_descriptor_;
  PeerConnections peers_;  ///< the thread's
  std::atomic<std::int64_t> refused_count_ = 0;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor_;
  std::thread thread_;
};

}  // namespace dcloc::server
