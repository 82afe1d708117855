#include "server/config/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/base/status.h"
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

}  // namespace
}  // namespace dcloc::server
