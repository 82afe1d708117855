#pragma once

#include <prometheus/collectable.h>

#include <functional>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "server/net/listen_address.h"
#include "server/telemetry/http_pages.h"

namespace dcloc::server {

/// Serves http://ADDRESS/metrics in Prometheus' text format, and /ready for load balancers: 200
/// with what `ready` says, or 503 with the reason. `ready` takes no time. Plaintext without access
/// control: metrics contain counts, but no names of vehicles, maps or callers. Unavailable when the
/// address cannot be listened on; port 0 takes a free one.
absl::StatusOr<std::unique_ptr<HttpPages>> ServeMetrics(
    const ListenAddress& address,
    std::vector<std::shared_ptr<prometheus::Collectable>> collectables,
    std::function<absl::StatusOr<std::string>()> ready);

/// HOST:PORT, or PORT alone for 127.0.0.1. InvalidArgument names `metrics_listen`, the value and
/// what it must be.
absl::StatusOr<ListenAddress> ParseMetricsAddress(absl::string_view text);

}  // namespace dcloc::server
