#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

namespace dcloc::server {

/// How long a call may still wait for its peer. Thread-safe.
class PeerWait {
 public:
  using Clock = std::chrono::steady_clock;

  /// The peer is waited for from now on, for at most `limit`.
  void Begin(std::chrono::milliseconds limit) {
    deadline_ = (Clock::now() + limit).time_since_epoch().count();
  }

  /// It has come.
  void End() { deadline_ = kNever; }

  /// Whether it has lasted too long; true once for each wait.
  bool TakeOverdue(Clock::time_point now) {
    Clock::rep deadline = deadline_;
    return now.time_since_epoch().count() > deadline &&
           deadline_.compare_exchange_strong(deadline, kNever);
  }

 private:
  static constexpr Clock::rep kNever = std::numeric_limits<Clock::rep>::max();

  std::atomic<Clock::rep> deadline_ = kNever;
};

/// A call that its peer can hold up, by not sending or not reading.
class PeerBoundCall {
 public:
  virtual ~PeerBoundCall() = default;

  /// Ends the call if its peer is overdue. Called by a thread that is not gRPC's.
  virtual void CheckPeer(PeerWait::Clock::time_point now) = 0;
};

/// Calls that ended because of their peer, since the start.
struct PeerFaultCounts {
  std::atomic<std::int64_t> not_sending = 0;       ///< a message did not come in time
  std::atomic<std::int64_t> not_reading = 0;       ///< an answer was not read in time
  std::atomic<std::int64_t> too_many_waiting = 0;  ///< others of the same peer have come since
};

/// The calls that may wait for a peer. Thread-safe.
class PeerBoundCalls {
 public:
  /// `call` is checked for as long as it lives.
  void Add(std::weak_ptr<PeerBoundCall> call);

  /// Ends the calls whose peers are overdue.
  void Check(PeerWait::Clock::time_point now);

  PeerFaultCounts& faults() { return faults_; }

 private:
  std::vector<std::shared_ptr<PeerBoundCall>> Living();

  std::mutex mutex_;
  std::vector<std::weak_ptr<PeerBoundCall>> calls_;
  PeerFaultCounts faults_;
};

}  // namespace dcloc::server
