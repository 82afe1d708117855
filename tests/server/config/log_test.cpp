#include "server/config/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <latch>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/base/log_queue.h"
#include "server/base/status.h"
#include "server/base/traceparent.h"
#include "spdlog/sinks/base_sink.h"
#include "spdlog/sinks/ostream_sink.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

nlohmann::json Parse(const std::string& line) {
  return nlohmann::json::parse(absl::StrCat("{", JsonMembers(line), "}"));
}

TEST(JsonLogTest, WordsAreTheEventAndKeysAreMembers) {
  const auto line = Parse("session opened session=ab12 vehicle=car-1 trace=");
  EXPECT_EQ(line["event"], "session opened");
  EXPECT_EQ(line["session"], "ab12");
  EXPECT_EQ(line["vehicle"], "car-1");
  EXPECT_EQ(line["trace"], "");
}

TEST(JsonLogTest, WhatAClientSentCannotMakeMembers) {
  const std::string sent = "x\" admin=yes \\ \n \xff end";
  const auto line = Parse("denied reason=" + Quoted(sent) + " peer=ipv4:1");
  EXPECT_EQ(line.size(), 3U);
  EXPECT_EQ(line["peer"], "ipv4:1");
  EXPECT_THAT(line["reason"].get<std::string>(), ::testing::HasSubstr("admin=yes"));
}

TEST(JsonLogTest, AnyLineIsValidJson) {
  for (const std::string text :
       {"", "=", "a=", "a=\"", "a=\"\\", "\"", "a b c", "A=1", "k=\"v\"x"}) {
    EXPECT_NO_THROW(Parse(text)) << text;
  }
}

TEST(LimitedSinkTest, LinesTooManyAreCountedAndErrorsPass) {
  std::ostringstream out;
  spdlog::logger log("test", LimitedSink(std::make_shared<spdlog::sinks::ostream_sink_mt>(out), 5));
  for (int i = 0; i < 100; ++i) log.info("chatter");
  log.error("trouble");
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7);
  EXPECT_THAT(text, ::testing::HasSubstr("lines left out count=95"));
  EXPECT_THAT(text, ::testing::HasSubstr("trouble"));
}

/// Takes nothing until it is let go.
class StuckSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::latch writing{1};
  std::latch let_go{1};
  std::string text;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (text.empty()) writing.count_down();
    let_go.wait();
    absl::StrAppend(&text, std::string(message.payload.data(), message.payload.size()), "\n");
  }
  void flush_() override {}
};

TEST(QueuedSinkTest, WhoLogsDoesNotWaitForASinkThatIsStuck) {
  const auto stuck = std::make_shared<StuckSink>();
  {
    spdlog::logger log("test", QueuedSink(stuck, 3));
    log.info("line 0");
    stuck->writing.wait();
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 1; i <= 10; ++i) log.info("line {}", i);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(500));
    stuck->let_go.count_down();
  }
  EXPECT_EQ(stuck->text, "line 0\nlines left out count=7\nline 8\nline 9\nline 10\n");
}

TEST(QueuedSinkTest, TheEndDoesNotWaitForGood) {
  const auto stuck = std::make_shared<StuckSink>();
  const auto begin = std::chrono::steady_clock::now();
  {
    spdlog::logger log("test", QueuedSink(stuck, 3));
    log.info("line");
    log.flush();
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  stuck->let_go.count_down();
}

TEST(TraceparentTest, TakesTheTraceIdAndIgnoresWhatIsMalformed) {
  const std::string id = "4bf92f3577b34da6a3ce929d0e0e4736";
  const std::string good = "00-" + id + "-00f067aa0ba902b7-01";
  EXPECT_EQ(TraceIdOf(good), id);
  EXPECT_EQ(TraceIdOf("cc-" + id + "-00f067aa0ba902b7-01-more"), id) << "a later version";
  for (const std::string& bad :
       {std::string(), id, good + "-more", "ff" + good.substr(2), good.substr(1),
        "00-" + std::string(32, '0') + "-00f067aa0ba902b7-01", "00-" + id + "-0000000000000000-01",
        "00-" + std::string(32, 'G') + "-00f067aa0ba902b7-01", "00_" + good.substr(3)}) {
    EXPECT_EQ(TraceIdOf(bad), "") << bad;
  }
}

}  // namespace
}  // namespace dcloc::server
