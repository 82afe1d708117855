#include "server/app/part_options.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/status.h"
#include "server/net/listen_address.h"
#include "server/replicas/replica_address.h"

namespace dcloc::server {

int WorkerCount(const ServerConfig& config) {
  if (config.worker_count > 0) return config.worker_count;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

SessionTimeouts SessionTimeoutsOf(const ServerConfig& config) {
  return {.detached_timeout = std::chrono::milliseconds(config.session_detached_timeout_ms),
          .idle_timeout = std::chrono::milliseconds(config.session_idle_timeout_ms)};
}

MapStoreOptions MapStoreOptionsOf(const ServerConfig& config) {
  return {.max_warm_bytes = std::int64_t{config.warm_map_mib} << 20,
          .unfinished_upload_timeout = std::chrono::seconds(config.unfinished_upload_timeout_s),
          .quarantine_time = std::chrono::days(config.quarantine_days)};
}

absl::StatusOr<std::unique_ptr<SessionTickets>> TicketsOf(const ServerConfig& config) {
  if (config.ticket_keys.empty()) return nullptr;
  absl::StatusOr<std::unique_ptr<ServedTicketKeys>> keys =
      ServedTicketKeys::Load(config.ticket_keys);
  if (!keys.ok()) return keys.status();
  return std::make_unique<SessionTickets>(*std::move(keys),
                                          std::chrono::seconds(config.ticket_lifetime_s),
                                          std::chrono::milliseconds(config.ticket_interval_ms));
}

ReplicaTls ReplicaTlsOf(const ServerConfig& config) {
  return {.enabled = !config.tls_cert.empty(),
          .ca = config.replica_ca,
          .cert = config.replica_cert,
          .key = config.replica_key};
}

absl::StatusOr<std::string> ReplicaAddressOf(const ServerConfig& config, int port) {
  const std::string& text = config.replica_address;
  const bool has_port = ParseListenAddress(text).ok();
  absl::StatusOr<ListenAddress> address =
      ParseListenAddress(has_port ? text : absl::StrCat(text, ":", port));
  if (!address.ok() || address->host == "0.0.0.0" || address->host == "::") {
    return absl::InvalidArgumentError(absl::StrCat(
        "replica_address is ", Quoted(text), "; it must be a HOST[:PORT] that others can reach"));
  }
  if (address->port == 0) address->port = port;
  std::string checked = address->ToString();
  if (!IsReplicaAddress(checked)) {
    return absl::InvalidArgumentError(absl::StrCat("replica_address is ", Quoted(text),
                                                   "; its host must be a name or an address"));
  }
  return checked;
}

}  // namespace dcloc::server
