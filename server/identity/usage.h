#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "server/base/rate_limit.h"
#include "server/config/limits.h"
#include "server/identity/principal.h"

namespace dcloc::server {

/// The sessions, scans and position fixes of one principal.
struct PrincipalUsage {
  std::atomic<int> session_count = 0;
  RateLimit scans;
  RateLimit fixes;
};

/// The right to hold one session; given back when this is destroyed. Thread-safe.
class SessionPermit {
 public:
  SessionPermit(const Limits& limits, std::shared_ptr<PrincipalUsage> usage);
  ~SessionPermit();
  SessionPermit(const SessionPermit&) = delete;
  SessionPermit& operator=(const SessionPermit&) = delete;

  /// Charges one scan of so many targets to the principal. ResourceExhausted names the limit and
  /// its value.
  absl::Status ChargeScan(int target_count, std::chrono::steady_clock::time_point now) const;

  /// Charges one position fix. They may come as fast as scans may, and take nothing from those.
  absl::Status ChargeFix(std::chrono::steady_clock::time_point now) const;

 private:
  const Limits& limits_;
  std::shared_ptr<PrincipalUsage> usage_;
};

/// Counts what principals use. Thread-safe.
class UsageCounts {
 public:
  /// `limits` outlives it and the permits.
  explicit UsageCounts(const Limits& limits) : limits_(limits) {}

  /// ResourceExhausted names the limit and its value.
  absl::StatusOr<std::shared_ptr<const SessionPermit>> TakeSession(const Principal& principal);

 private:
  const Limits& limits_;
  std::mutex mutex_;
  std::map<std::pair<std::string, std::string>, std::weak_ptr<PrincipalUsage>> usages_;
};

}  // namespace dcloc::server
