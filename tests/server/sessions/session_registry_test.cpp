#include "server/sessions/session_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/server/sessions/session_test_parts.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class FakeStream final : public SessionStream {
 public:
  void Announce(const v1::SessionEnding& ending) override { announced = ending.message(); }
  void End(grpc::Status status) override { ended = status.error_message(); }
  void Displace(grpc::Status /*status*/) override {}
  void Abort() override { ++abort_count; }

  std::string announced;
  std::string ended;
  int abort_count = 0;
};

class SessionRegistryTest : public SessionParts {
 protected:
  using Clock = SessionRegistry::Clock;

  SessionRegistryTest() { EXPECT_TRUE(registry_.Add(session_->info(), session_, stream_).ok()); }

  absl::Status EndSession() {
    v1::SessionEnding ending;
    ending.set_message("enough");
    return registry_.End("session", "", ending);
  }

  absl::Status Find() { return registry_.Find("secret", {}, "").status(); }

  bool IsListedDetached() { return registry_.Get("", "session")->detached; }

  static constexpr std::chrono::minutes kTimeout{1};
  SessionRegistry registry_{limits_, {.detached_timeout = kTimeout}};
  std::shared_ptr<Session> session_ = MakeSession();
  SessionInfo& info_ = *session_->info();
  std::shared_ptr<FakeStream> stream_ = std::make_shared<FakeStream>();
};

TEST_F(SessionRegistryTest, ADetachedSessionIsResumed) {
  registry_.Detach(info_, *stream_);
  EXPECT_TRUE(IsListedDetached());
  EXPECT_TRUE(Find().ok());
  const auto another = std::make_shared<FakeStream>();
  const auto before = registry_.Attach(info_, another);
  ASSERT_TRUE(before.ok());
  EXPECT_EQ(*before, nullptr);
  EXPECT_FALSE(IsListedDetached());
  EXPECT_EQ(registry_.resume_count(), 1);
}

TEST_F(SessionRegistryTest, ATakeoverNamesTheStreamBefore) {
  const auto another = std::make_shared<FakeStream>();
  const auto before = registry_.Attach(info_, another);
  ASSERT_TRUE(before.ok());
  EXPECT_EQ(before->get(), stream_.get());
  registry_.Detach(info_, *stream_);
  EXPECT_FALSE(IsListedDetached()) << "the stream before has no say any more";
  registry_.Remove(info_, *stream_, "closed");
  EXPECT_EQ(registry_.count(), 1);
}

TEST_F(SessionRegistryTest, WhoIsToldToEndAndDoesNotIsCutOff) {
  ASSERT_TRUE(EndSession().ok());
  EXPECT_EQ(stream_->announced, "enough");
  EXPECT_EQ(stream_->ended, "enough");
  EXPECT_EQ(registry_.Attach(info_, stream_).status().code(), absl::StatusCode::kNotFound);
  registry_.Reap(Clock::now());
  EXPECT_EQ(stream_->abort_count, 0);
  registry_.Reap(Clock::now() + std::chrono::seconds(6));
  EXPECT_EQ(stream_->abort_count, 1);
  EXPECT_EQ(registry_.count(), 1) << "its stream lets go of it";
}

TEST_F(SessionRegistryTest, AnAbandonedSessionIsNotResumedAndGoesAfterATime) {
  ASSERT_TRUE(EndSession().ok());
  registry_.Detach(info_, *stream_);
  EXPECT_TRUE(IsListedDetached());
  const absl::Status refused = registry_.Attach(info_, stream_).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("is being ended"));
  registry_.Reap(Clock::now() + kTimeout);
  EXPECT_EQ(registry_.count(), 0);
}

TEST_F(SessionRegistryTest, ADetachedSessionEndsAtOnceAndSaysWhy) {
  registry_.Detach(info_, *stream_);
  ASSERT_TRUE(EndSession().ok());
  EXPECT_EQ(registry_.count(), 0);
  EXPECT_EQ(stream_->ended, "");
  EXPECT_THAT(std::string(Find().message()), HasSubstr("the session has ended: enough"));
}

TEST_F(SessionRegistryTest, AStreamThatClosesEndsItsSession) {
  registry_.Remove(info_, *stream_, "its client closed it");
  EXPECT_EQ(registry_.count(), 0);
  EXPECT_THAT(std::string(Find().message()), HasSubstr("its client closed it"));
}

TEST_F(SessionRegistryTest, AStreamThatIsGoneCannotBeToldToEnd) {
  stream_.reset();
  ASSERT_TRUE(EndSession().ok());
  EXPECT_EQ(registry_.count(), 0);
  EXPECT_THAT(std::string(Find().message()), HasSubstr("enough"));
}

TEST_F(SessionRegistryTest, ADrainEndsWhatIsDetachedAlone) {
  registry_.RemoveDetached("the server stops");
  EXPECT_EQ(registry_.count(), 1) << "its stream ends it";
  registry_.Detach(info_, *stream_);
  registry_.RemoveDetached("the server stops");
  EXPECT_EQ(registry_.count(), 0);
  EXPECT_THAT(std::string(Find().message()), HasSubstr("the server stops"));
}

TEST_F(SessionRegistryTest, OneWithoutScansForTooLongIsToldToEnd) {
  registry_.Reap(Clock::now() + std::chrono::minutes(9));
  EXPECT_EQ(stream_->ended, "");
  registry_.Reap(Clock::now() + std::chrono::minutes(11));
  EXPECT_EQ(stream_->ended, "no scan came for 10m");
  EXPECT_EQ(registry_.count(), 1);
}

TEST_F(SessionRegistryTest, AStreamThatIsGoneWithoutAWordHasDetached) {
  ASSERT_TRUE(EndSession().ok());
  stream_.reset();
  registry_.Reap(Clock::now());
  registry_.Reap(Clock::now() + kTimeout);
  EXPECT_EQ(registry_.count(), 0);
}

TEST_F(SessionRegistryTest, TheLongestDetachedMakesRoom) {
  limits_.max_session_count = 1;
  auto info = std::make_shared<SessionInfo>();
  info->description.session_id = "another";
  EXPECT_EQ(registry_.Add(info, session_, stream_).code(), absl::StatusCode::kResourceExhausted);
  registry_.Detach(info_, *stream_);
  EXPECT_TRUE(registry_.Add(info, session_, stream_).ok());
  EXPECT_EQ(registry_.count(), 1);
  EXPECT_EQ(registry_.Get("", "session").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc::server
