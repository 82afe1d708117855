#include "server/sessions/answer_feed.h"

#include <utility>

#include "absl/strings/str_format.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

absl::Status AnswerFeed::Subscribe(const std::shared_ptr<AnswerSubscriber>& subscriber) {
  {
    const std::lock_guard lock(mutex_);
    ForgetWhoIsGone();
    if (subscribers_.size() >= kMaxSubscribers) {
      return absl::ResourceExhaustedError(
          absl::StrFormat("%d watch the session, which is the limit", kMaxSubscribers));
    }
    if (!closed_) {
      subscribers_.push_back(subscriber);
      has_subscribers_ = true;
      return absl::OkStatus();
    }
  }
  subscriber->OnEnd();
  return absl::OkStatus();
}

void AnswerFeed::ForgetWhoIsGone() {
  std::erase_if(subscribers_, [](const auto& subscriber) { return subscriber.expired(); });
}

void AnswerFeed::Publish(const ScanAnswer& answer, const v1::Scan* scan) {
  TellAll([&](AnswerSubscriber& subscriber) { subscriber.OnAnswer(answer, scan); });
}

void AnswerFeed::Publish(const FixAnswer& answer) {
  TellAll([&](AnswerSubscriber& subscriber) { subscriber.OnFixAnswer(answer); });
}

template <typename Tell>
void AnswerFeed::TellAll(Tell tell) {
  if (!has_subscribers_) return;
  const std::lock_guard lock(mutex_);
  ForgetWhoIsGone();
  for (const auto& entry : subscribers_) {
    const auto subscriber = entry.lock();
    // Who gets no memory for an answer misses it; the vehicle does not.
    if (subscriber != nullptr) WithinMemory([&] { tell(*subscriber); }).IgnoreError();
  }
  has_subscribers_ = !subscribers_.empty();
}

void AnswerFeed::Close() {
  std::vector<std::weak_ptr<AnswerSubscriber>> subscribers;
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    has_subscribers_ = false;
    subscribers = std::exchange(subscribers_, {});
  }
  for (const auto& entry : subscribers) {
    if (const auto subscriber = entry.lock()) subscriber->OnEnd();
  }
}

}  // namespace dcloc::server
