#include "server/sessions/answer_feed.h"

#include <utility>

namespace dcloc::server {

void AnswerFeed::Subscribe(const std::shared_ptr<AnswerListener>& listener) {
  {
    const std::lock_guard lock(mutex_);
    if (!closed_) {
      listeners_.push_back(listener);
      has_listeners_ = true;
      return;
    }
  }
  listener->OnEnd();
}

void AnswerFeed::Publish(const v1::LocalizeResponse& answer) {
  if (!has_listeners_) return;
  const std::lock_guard lock(mutex_);
  std::erase_if(listeners_, [](const auto& listener) { return listener.expired(); });
  for (const auto& entry : listeners_) {
    if (const auto listener = entry.lock()) listener->OnAnswer(answer);
  }
  has_listeners_ = !listeners_.empty();
}

void AnswerFeed::Close() {
  std::vector<std::weak_ptr<AnswerListener>> listeners;
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    has_listeners_ = false;
    listeners = std::exchange(listeners_, {});
  }
  for (const auto& entry : listeners) {
    if (const auto listener = entry.lock()) listener->OnEnd();
  }
}

}  // namespace dcloc::server
