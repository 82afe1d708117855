#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/config/config.h"

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

  /// HOST:PORT of the metrics; empty when they are not served.
  std::string metrics_address() const;

  /// Takes what of `config` can change while the server runs (`ConfigField::reloadable`) and logs
  /// what has changed and what needs a restart. InvalidArgument when `config` is not valid, and
  /// then nothing changes.
  absl::Status Reload(const ServerConfig& config);

  /// Refuses new sessions and tells those that can to move, then answers what the others have sent,
  /// ends their streams with UNAVAILABLE, and cuts off what is still open after `deadline`. Returns
  /// when nothing runs any more.
  void Shutdown(std::chrono::milliseconds deadline);

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace dcloc::server
