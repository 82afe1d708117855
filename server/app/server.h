#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "core/registration/registration_method.h"
#include "server/config/config.h"

namespace dcloc::server {

/// A running dcloc server: map store, worker pools, and the gRPC services over them.
class Server {
 public:
  /// Opens the store and listens. Errors name what of the configuration is at fault. `methods`
  /// replace core's registration in all sessions, but for those of the stub.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerConfig& config,
                                                       RegistrationMethods methods = {});

  /// Shuts down at once unless `Shutdown` was called.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// HOST:PORT with the real port.
  const std::string& address() const;

  /// HOST:PORT of the metrics; empty when they are not served.
  std::string metrics_address() const;

  /// Applies the settings of `config` that can change while the server runs
  /// (`ConfigField::reloadable`). Logs which have changed and which need a restart. InvalidArgument
  /// when `config` is not valid; then nothing changes.
  absl::Status Reload(const ServerConfig& config);

  /// Refuses new sessions and tells resumable ones to move. Answers the scans that were read from
  /// the others and ends their streams with UNAVAILABLE. Cuts off calls that are still open after
  /// `deadline`. Returns when no call runs.
  void Shutdown(std::chrono::milliseconds deadline);

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace dcloc::server
