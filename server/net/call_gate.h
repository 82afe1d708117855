#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/base/memory_reserve.h"
#include "server/base/rate_limit.h"

namespace dcloc::server {

/// Refuses calls where it costs least: when their headers have come, on the thread that reads their
/// connection. Behind it each call goes through queues that vehicles' calls also wait in.
/// Thread-safe.
class CallGate {
 public:
  struct RefusedCounts {
    std::atomic<std::int64_t> without_proof = 0;
    std::atomic<std::int64_t> too_fast = 0;
    std::atomic<std::int64_t> out_of_memory = 0;
  };

  /// A connection may begin `max_rate_hz` calls a second; 0: as many as it likes. While `reserve`
  /// is given, which is in use for as long as the gate is, none may.
  explicit CallGate(int max_rate_hz, const MemoryReserve& reserve = MemoryReserve::OfProcess())
      : max_rate_hz_(max_rate_hz), reserve_(reserve) {
    proof_needed_ = false;  // hands the whole gate over to threads that read this first
  }

  /// Whether callers need a proof of their identity at all.
  void SetProofNeeded(bool needed) { proof_needed_ = needed; }

  /// OK, or the status that a call ends with: Unauthenticated for one without a proof, though only
  /// health and reflection are for everyone; ResourceExhausted for one that comes too fast,
  /// or while memory is short.
  /// `connection` is its identity, which may be used again by a later one.
  absl::Status Admit(const void* connection, absl::string_view path, bool has_proof,
                     RateLimit::Clock::time_point now);

  const RefusedCounts& refused() const { return refused_; }

 private:
  struct Rate {
    RateLimit limit;
    RateLimit::Clock::time_point last;
  };

  bool TakeRate(const void* connection, RateLimit::Clock::time_point now);

  const int max_rate_hz_;
  const MemoryReserve& reserve_;
  std::atomic<bool> proof_needed_;
  RefusedCounts refused_;
  std::mutex mutex_;
  std::map<const void*, Rate> rates_;
};

}  // namespace dcloc::server
