#include "server/objects/circuit_breaker.h"

#include "server/base/status.h"
#include "server/objects/object_error.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

absl::StatusOr<CircuitBreaker::Pass> CircuitBreaker::Enter() {
  const std::lock_guard lock(mutex_);
  if (!away_) return Pass::kFree;
  if (probe_under_way_ || Clock::now() < next_probe_) return ObjectStoreError("away a moment ago");
  probe_under_way_ = true;
  return Pass::kProbe;
}

void CircuitBreaker::Note(const absl::Status& outcome) {
  const std::lock_guard lock(mutex_);
  probe_under_way_ = false;
  if (outcome.ok()) {
    if (away_.exchange(false)) spdlog::info("object store back");
    return;
  }
  next_probe_ = Clock::now() + interval_;
  if (away_.exchange(true)) return;
  spdlog::error("object store away reason={}", Quoted(ObjectStoreReason(outcome)));
}

}  // namespace dcloc::server
