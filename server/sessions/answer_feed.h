#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include "absl/status/status.h"
#include "dcloc/v1/scan.pb.h"
#include "server/convert/answer.h"
#include "server/convert/position_fix.h"

namespace dcloc::server {

/// Watches a session. Called on the session's strand, so it must not wait.
class AnswerSubscriber {
 public:
  virtual ~AnswerSubscriber() = default;
  /// `scan` is as the client sent it; null where it was dropped for newer ones.
  virtual void OnAnswer(const ScanAnswer& answer, const v1::Scan* scan) = 0;
  virtual void OnFixAnswer(const FixAnswer& answer) = 0;
  /// The session has ended; the last call.
  virtual void OnEnd() = 0;
};

/// Hands a session's answers to its watchers. Thread-safe; costs one atomic read while there is
/// none.
class AnswerFeed {
 public:
  /// Watchers of one session at most, as it waits while each of them is told.
  static constexpr std::size_t kMaxSubscribers = 64;

  /// `subscriber` gets all later answers, for as long as it lives. ResourceExhausted when there are
  /// too many.
  absl::Status Subscribe(const std::shared_ptr<AnswerSubscriber>& subscriber);

  void Publish(const ScanAnswer& answer, const v1::Scan* scan);
  void Publish(const FixAnswer& answer);

  /// The session has ended: no more answers follow.
  void Close();

 private:
  template <typename Tell>
  void TellAll(Tell tell);
  void ForgetWhoIsGone();

  std::atomic<bool> has_subscribers_ = false;
  std::mutex mutex_;
  std::vector<std::weak_ptr<AnswerSubscriber>> subscribers_;
  bool closed_ = false;
};

}  // namespace dcloc::server
