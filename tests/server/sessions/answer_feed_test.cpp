#include "server/sessions/answer_feed.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

namespace dcloc::server {
namespace {

class AnswerLog final : public AnswerSubscriber {
 public:
  void OnAnswer(const ScanAnswer& answer, const v1::Scan* /*scan*/) override {
    text += std::to_string(answer.sequence_number);
  }
  void OnFixAnswer(const FixAnswer& /*answer*/) override { text += 'f'; }
  void OnEnd() override { text += '.'; }

  std::string text;
};

ScanAnswer Answer(std::int64_t sequence_number) {
  return {
      .sequence_number = sequence_number, .result = absl::CancelledError(), .ticket = std::nullopt};
}

TEST(AnswerFeedTest, AWatcherGetsWhatComesAfterItSubscribed) {
  AnswerFeed feed;
  const auto early = std::make_shared<AnswerLog>();
  const auto late = std::make_shared<AnswerLog>();
  feed.Publish(Answer(1), nullptr);
  feed.Subscribe(early);
  feed.Publish(Answer(2), nullptr);
  feed.Subscribe(late);
  feed.Publish(FixAnswer());
  feed.Publish(Answer(3), nullptr);
  feed.Close();
  EXPECT_EQ(early->text, "2f3.");
  EXPECT_EQ(late->text, "f3.");
}

TEST(AnswerFeedTest, WhoIsGoneIsLeftOut) {
  AnswerFeed feed;
  auto gone = std::make_shared<AnswerLog>();
  const auto stays = std::make_shared<AnswerLog>();
  feed.Subscribe(gone);
  feed.Subscribe(stays);
  gone.reset();
  feed.Publish(Answer(1), nullptr);
  EXPECT_EQ(stays->text, "1");
}

TEST(AnswerFeedTest, AnEndedSessionSaysSoAndNothingElse) {
  AnswerFeed feed;
  feed.Close();
  const auto watcher = std::make_shared<AnswerLog>();
  feed.Subscribe(watcher);
  feed.Publish(Answer(1), nullptr);
  feed.Close();
  EXPECT_EQ(watcher->text, ".");
}

}  // namespace
}  // namespace dcloc::server
