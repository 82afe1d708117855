#include "server/sessions/answer_feed.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

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
  ASSERT_TRUE(feed.Subscribe(early).ok());
  feed.Publish(Answer(2), nullptr);
  ASSERT_TRUE(feed.Subscribe(late).ok());
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
  ASSERT_TRUE(feed.Subscribe(gone).ok());
  ASSERT_TRUE(feed.Subscribe(stays).ok());
  gone.reset();
  feed.Publish(Answer(1), nullptr);
  EXPECT_EQ(stays->text, "1");
}

TEST(AnswerFeedTest, OneTooManyIsRefusedUntilAnotherHasGone) {
  AnswerFeed feed;
  std::vector<std::shared_ptr<AnswerLog>> watchers;
  for (std::size_t i = 0; i < AnswerFeed::kMaxSubscribers; ++i) {
    watchers.push_back(std::make_shared<AnswerLog>());
    ASSERT_TRUE(feed.Subscribe(watchers.back()).ok());
  }
  const auto late = std::make_shared<AnswerLog>();
  EXPECT_TRUE(absl::IsResourceExhausted(feed.Subscribe(late)));
  watchers.pop_back();
  EXPECT_TRUE(feed.Subscribe(late).ok());
  feed.Publish(Answer(1), nullptr);
  EXPECT_EQ(late->text, "1");
}

TEST(AnswerFeedTest, AnEndedSessionSaysSoAndNothingElse) {
  AnswerFeed feed;
  feed.Close();
  const auto watcher = std::make_shared<AnswerLog>();
  ASSERT_TRUE(feed.Subscribe(watcher).ok());
  feed.Publish(Answer(1), nullptr);
  feed.Close();
  EXPECT_EQ(watcher->text, ".");
}

}  // namespace
}  // namespace dcloc::server
