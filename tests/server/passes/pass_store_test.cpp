#include "server/passes/pass_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <string>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/passes/pass_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class PassStoreTest : public ::testing::Test {
 protected:
  absl::Status Add(const std::string& vehicle_id = "car-1",
                   const PassBounds& bounds = kWideBounds) {
    NewPass pass = TownPass();
    pass.vehicle_id = vehicle_id;
    pass.scan_count = 60;
    pass.size_bytes = static_cast<std::int64_t>(text_.size());
    pass.sha256 = Sha256Of(std::as_bytes(std::span(text_)));
    return passes_.store->Add(pass, Local(), bounds);
  }

  std::filesystem::path Local() {
    return passes_.folder.Write("local", std::as_bytes(std::span(text_)));
  }

  const std::string text_ = "scans";
  TestPasses passes_;
};

TEST_F(PassStoreTest, WhatIsKeptNamesNobody) {
  ASSERT_TRUE(Add("car-1").ok());
  ASSERT_TRUE(Add("car-1").ok());
  ASSERT_TRUE(Add("car-2").ok());
  const auto list = passes_.List();
  ASSERT_EQ(list.size(), 3U);
  EXPECT_EQ(list[1].vehicle, list[2].vehicle);
  EXPECT_NE(list[0].vehicle, list[1].vehicle);
  for (const PassRow& row : list) {
    EXPECT_EQ(row.vehicle.size(), 32U);
    EXPECT_THAT(row.vehicle, Not(HasSubstr("car")));
    EXPECT_NE(row.vehicle, row.identity) << "one does not tell the other";
  }
  EXPECT_EQ(passes_.FileCount(), 3U);
}

TEST_F(PassStoreTest, WithoutAKeyNothingIsKept) {
  const TestPasses keyless("");
  EXPECT_EQ(keyless.store->CheckKeeps().code(), absl::StatusCode::kFailedPrecondition);
  const absl::Status status =
      keyless.store->GiveConsent("", {.subject = ConsentSubject::kMap, .name = "town"});
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), HasSubstr("pass_key"));
  EXPECT_FALSE(*keyless.store->MayKeep("", "town", "car-1"));
  EXPECT_EQ(*keyless.store->WithdrawConsent("", {.name = "town"}), 0);
  const auto withdrawn =
      keyless.store->WithdrawConsent("", {.subject = ConsentSubject::kIdentity, .name = "car-1"});
  EXPECT_EQ(withdrawn.status().code(), absl::StatusCode::kFailedPrecondition)
      << "its passes would stay";
}

TEST_F(PassStoreTest, WhatIsRefusedLeavesNoFile) {
  PassBounds narrow = kWideBounds;
  narrow.quota.max_tenant_bytes = 3;
  EXPECT_EQ(Add("car-1", narrow).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(passes_.FileCount(), 0U);
  EXPECT_FALSE(std::filesystem::exists(passes_.folder.path() / "local"));
}

TEST_F(PassStoreTest, FilesGoWithTheConsentAndWithTheTime) {
  ASSERT_TRUE(Add().ok());
  EXPECT_EQ(
      *passes_.store->WithdrawConsent("", {.subject = ConsentSubject::kIdentity, .name = "car-1"}),
      1);
  EXPECT_EQ(passes_.FileCount(), 0U);
  EXPECT_EQ(Add().code(), absl::StatusCode::kPermissionDenied);
  ASSERT_TRUE(
      passes_.store->GiveConsent("", {.subject = ConsentSubject::kIdentity, .name = "car-1"}).ok());
  ASSERT_TRUE(Add().ok());
  const SystemTime now = std::chrono::system_clock::now();
  EXPECT_EQ(*passes_.store->RemoveExpired(now + std::chrono::hours(23)), 0);
  EXPECT_EQ(*passes_.store->RemoveExpired(now + std::chrono::hours(25)), 1);
  EXPECT_EQ(passes_.FileCount(), 0U);
}

TEST_F(PassStoreTest, AFileWithoutAPassIsRemovedWhenItIsSeenTwice) {
  ASSERT_TRUE(Add().ok());
  passes_.folder.Write("passes/0123", std::as_bytes(std::span(text_)));
  EXPECT_EQ(*passes_.store->RemoveOrphans(), 0);
  EXPECT_EQ(passes_.FileCount(), 2U);
  EXPECT_EQ(*passes_.store->RemoveOrphans(), 1);
  EXPECT_EQ(passes_.FileCount(), 1U);
}

}  // namespace
}  // namespace dcloc::server
