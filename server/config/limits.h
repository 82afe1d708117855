#pragma once

#include <atomic>

#include "server/config/config.h"

namespace dcloc::server {

/// The limits that may change while the server runs; 0 is no limit where that is said. Read by any
/// thread, one value at a time.
struct Limits {
  explicit Limits(const ServerConfig& config) { Set(config); }

  void Set(const ServerConfig& config) {
    max_session_count = config.max_session_count;
    max_unopened_stream_count = config.max_unopened_stream_count;
    max_unopened_stream_count_per_peer = config.max_unopened_stream_count_per_peer;
    open_timeout_ms = config.open_timeout_ms;
    peer_timeout_ms = config.peer_timeout_ms;
    max_session_count_per_principal = config.max_session_count_per_principal;
    max_scan_rate_hz_per_principal = config.max_scan_rate_hz_per_principal;
    max_download_count = config.max_download_count;
    max_download_count_per_caller = config.max_download_count_per_caller;
    max_target_count = config.max_target_count;
    max_map_mib = config.max_map_mib;
    max_tenant_storage_mib = config.max_tenant_storage_mib;
    pass_storage_mib = config.pass_storage_mib;
    pass_vehicle_mib_per_day = config.pass_vehicle_mib_per_day;
    pass_retention_days = config.pass_retention_days;
  }

  std::atomic<int> max_session_count;
  std::atomic<int> max_unopened_stream_count;
  std::atomic<int> max_unopened_stream_count_per_peer;  ///< 0: none of its own
  std::atomic<int> open_timeout_ms;
  std::atomic<int> peer_timeout_ms;
  std::atomic<int> max_session_count_per_principal;  ///< 0: none
  std::atomic<int> max_scan_rate_hz_per_principal;   ///< 0: none
  std::atomic<int> max_download_count;
  std::atomic<int> max_download_count_per_caller;
  std::atomic<int> max_target_count;
  std::atomic<int> max_map_mib;
  std::atomic<int> max_tenant_storage_mib;  ///< 0: none
  std::atomic<int> pass_storage_mib;
  std::atomic<int> pass_vehicle_mib_per_day;
  std::atomic<int> pass_retention_days;
};

}  // namespace dcloc::server
