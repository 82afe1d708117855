#include "server/tickets/ticket_keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/server/tickets/ticket_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(TicketKeysTest, TheFirstOneSealsAndCommentsAreSkipped) {
  const auto keys =
      ParseTicketKeys(absl::StrCat("# ours\n\n  ", KeyLine("b", 'B'), KeyLine("a", '0')));
  ASSERT_TRUE(keys.ok()) << keys.status();
  ASSERT_EQ(keys->size(), 2U);
  EXPECT_EQ((*keys)[0].id, "b");
  EXPECT_EQ((*keys)[0].secret[31], 0xbb);
  EXPECT_EQ((*keys)[1].id, "a");
}

TEST(TicketKeysTest, WhatIsNoKeyIsRefusedByItsLineAndWithoutTheSecret) {
  const std::string secret(64, '7');
  const std::string good = KeyLine("a", '1');
  const std::string wrongs[] = {
      "",
      "# nothing\n",
      absl::StrCat(good, "b ", secret.substr(1), "\n"),
      absl::StrCat(good, "b ", secret, "7\n"),
      absl::StrCat(good, "b ", secret.substr(1), "g\n"),
      absl::StrCat(good, secret, "\n"),
      absl::StrCat(good, "b\t", secret, " more\n"),
      absl::StrCat(good, "no/name ", secret, "\n"),
      absl::StrCat(good, "a-name-of-17-char ", secret, "\n"),
      absl::StrCat(good, KeyLine("a", '7')),
  };
  for (const std::string& text : wrongs) {
    const auto keys = ParseTicketKeys(text);
    EXPECT_EQ(keys.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(keys.status().message()), Not(HasSubstr("7777"))) << text;
    if (text.size() > 60) {
      EXPECT_THAT(std::string(keys.status().message()), HasSubstr("line 2"));
    }
  }
}

TEST(TicketKeysTest, ThereAreNotTooMany) {
  std::string text;
  for (std::size_t i = 0; i <= kMaxTicketKeys; ++i)
    absl::StrAppend(&text, KeyLine(absl::StrCat("k", i), '1'));
  EXPECT_FALSE(ParseTicketKeys(text).ok());
}

TEST(TicketKeysTest, AFileThatEveryoneMayReadIsRefused) {
  const KeyFile file(KeyLine("a", '1'));
  EXPECT_TRUE(ReadTicketKeys(file.path).ok());
  std::filesystem::permissions(file.path, std::filesystem::perms(0604));
  EXPECT_THAT(std::string(ReadTicketKeys(file.path).status().message()), HasSubstr("0600"));
  EXPECT_THAT(std::string(ReadTicketKeys(file.path / "no").status().message()),
              HasSubstr("ticket_keys"));
}

TEST(ServedTicketKeysTest, NewKeysAreTakenOnceTheFileStaysAndBadOnesNever) {
  KeyFile file(KeyLine("a", '1'));
  const auto served = ServedTicketKeys::Load(file.path);
  ASSERT_TRUE(served.ok());
  EXPECT_EQ((*served)->cipher()->key_id(), "a");
  const auto wait_for = [&](const std::string& id) {
    for (int i = 0; i < 100 && (*served)->cipher()->key_id() != id; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return (*served)->cipher()->key_id() == id;
  };
  file.Write(absl::StrCat(KeyLine("b", '2'), KeyLine("a", '1')));
  EXPECT_TRUE(wait_for("b"));
  file.Write("half of a li");
  EXPECT_FALSE(ServedTicketKeys::Load(file.path).ok());
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  EXPECT_EQ((*served)->cipher()->key_id(), "b");
  file.Write(KeyLine("c", '3'));
  EXPECT_TRUE(wait_for("c"));
}

}  // namespace
}  // namespace dcloc::server
