#pragma once

#include <grpcpp/server.h>

#include <mutex>

namespace dcloc::server {

/// What `grpc.health.v1` tells of the server as a whole (the empty name) and of each of its
/// services. One that drains localizes nobody any more, but still speaks of maps and of itself.
/// Thread-safe.
class Health {
 public:
  /// `server` outlives this, and is well.
  explicit Health(grpc::Server& server);

  /// Whether it answers new connections.
  void SetAnswering(bool answering);

  /// For good.
  void SetDraining();

 private:
  void Tell();

  grpc::Server& server_;
  std::mutex mutex_;
  bool answering_ = true;
  bool draining_ = false;
};

}  // namespace dcloc::server
