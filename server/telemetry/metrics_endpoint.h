#pragma once

#include <prometheus/collectable.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "server/net/listen_address.h"
#include "server/net/listen_sockets.h"

namespace dcloc::server {

/// Serves http://ADDRESS/metrics in Prometheus' text format, and /ready for load balancers (200, or
/// 503 with the reason). Plaintext without access control: metrics contain counts, but no names of
/// vehicles, maps or callers. One connection at a time, with at most a second for the request and
/// another one for the response.
class MetricsEndpoint {
 public:
  /// Port 0 takes a free one. Unavailable when the address cannot be listened on.
  static absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Start(
      const ListenAddress& address,
      std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
      std::function<absl::Status()> ready);
  ~MetricsEndpoint();
  MetricsEndpoint(const MetricsEndpoint&) = delete;
  MetricsEndpoint& operator=(const MetricsEndpoint&) = delete;

  /// HOST:PORT with the real port.
  const std::string& address() const { return address_; }

 private:
  MetricsEndpoint(ListenSockets listening, FileDescriptor wake, std::string address,
                  std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
                  std::function<absl::Status()> ready);
  void Run() const;
  void Serve(int listening_fd) const;
  std::string Respond(absl::string_view request) const;

  const ListenSockets listening_;
  const FileDescriptor wake_;  ///< readable once it is to stop
  const std::string address_;
  const std::vector<std::shared_ptr<prometheus::Collectable>> collectables_;
  const std::function<absl::Status()> ready_;
  std::thread thread_;  ///< last: it uses the others
};

/// HOST:PORT, or PORT alone for 127.0.0.1. InvalidArgument names `metrics_listen`, the value and
/// what it must be.
absl::StatusOr<ListenAddress> ParseMetricsAddress(absl::string_view text);

}  // namespace dcloc::server
