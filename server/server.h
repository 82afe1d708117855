#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/config.h"

namespace dcloc::server {

/// A running dcloc server: map store, worker pools, and the gRPC services over them.
class Server {
 public:
  /// Opens the store and listens. Errors name what of the configuration is at fault.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerConfig& config);

  /// Shuts down at once if that has not been done.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// HOST:PORT with the real port.
  const std::string& address() const;

  /// Refuses new sessions, answers what the open ones have sent, ends their streams with
  /// UNAVAILABLE, and cuts off what is still open after `deadline`. Returns when nothing runs any
  /// more.
  void Shutdown(std::chrono::milliseconds deadline);

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace dcloc::server
