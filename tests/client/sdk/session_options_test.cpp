#include "client/sdk/session_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace dcloc::client {
namespace {

using std::chrono::milliseconds;

TEST(SessionOptionsTest, TheDefaultsHold) {
  SessionOptions options;
  EXPECT_TRUE(Validate(options).ok());
  options.reconnect = std::nullopt;
  EXPECT_TRUE(Validate(options).ok());
  options.unread_answers = UnreadAnswers::kForgetOldest;
  EXPECT_TRUE(Validate(options).ok());
}

TEST(SessionOptionsTest, EachFieldIsRefusedByItsName) {
  const std::pair<const char*, std::function<void(SessionOptions&)>> faults[] = {
      {"max_queued_scan_count", [](auto& options) { options.max_queued_scan_count = 0; }},
      {"max_unread_answer_count", [](auto& options) { options.max_unread_answer_count = 0; }},
      {"max_unanswered_scan_count", [](auto& options) { options.max_unanswered_scan_count = 0; }},
      {"max_unanswered_fix_count", [](auto& options) { options.max_unanswered_fix_count = 0; }},
      {"record_file",
       [](auto& options) {
         options.record_file = "a.session";
         options.unread_answers = UnreadAnswers::kForgetOldest;
       }},
      {"open_timeout", [](auto& options) { options.open_timeout = milliseconds(0); }},
      {"reconnect.initial_backoff",
       [](auto& options) { options.reconnect->initial_backoff = milliseconds(-1); }},
      {"reconnect.give_up_after",
       [](auto& options) { options.reconnect->give_up_after = milliseconds(0); }},
      {"reconnect.max_backoff",
       [](auto& options) { options.reconnect->max_backoff = milliseconds(99); }}};
  for (const auto& [name, spoil] : faults) {
    SessionOptions options;
    spoil(options);
    EXPECT_EQ(Validate(options).code(), absl::StatusCode::kInvalidArgument) << name;
    EXPECT_THAT(std::string(Validate(options).message()), ::testing::StartsWith(name));
  }
}

}  // namespace
}  // namespace dcloc::client
