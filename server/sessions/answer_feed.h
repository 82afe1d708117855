#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// Who looks on at a session. Called on the session's strand, so it must not wait.
class AnswerListener {
 public:
  virtual ~AnswerListener() = default;
  virtual void OnAnswer(const v1::LocalizeResponse& answer) = 0;
  /// The session has ended; the last call.
  virtual void OnEnd() = 0;
};

/// Hands a session's answers to whoever looks on. Thread-safe; costs one atomic read while nobody
/// does.
class AnswerFeed {
 public:
  /// `listener` hears of what comes from now on, for as long as it lives.
  void Subscribe(const std::shared_ptr<AnswerListener>& listener);

  void Publish(const v1::LocalizeResponse& answer);

  /// Nothing comes any more.
  void Close();

 private:
  std::atomic<bool> has_listeners_ = false;
  std::mutex mutex_;
  std::vector<std::weak_ptr<AnswerListener>> listeners_;
  bool closed_ = false;
};

}  // namespace dcloc::server
