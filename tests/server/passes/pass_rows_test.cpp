#include "server/passes/pass_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/fixtures/job_places.h"
#include "tests/server/fixtures/message_of.h"

// What each catalogue of passes promises.
namespace dcloc::server {
namespace {

using std::chrono::hours;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kAny = std::numeric_limits<std::int64_t>::max();
constexpr PassQuota kQuota{.max_tenant_bytes = 1000, .max_vehicle_bytes_per_day = 300};
const ConsentRow kTown{.subject = ConsentSubject::kMap, .name = "town"};
const ConsentRow kCar{.subject = ConsentSubject::kIdentity, .name = "car-1"};
const SystemTime kNow =
    std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now());

PassRow PassOf(const std::string& id, const std::string& vehicle = "v1") {
  return {.pass_id = id,
          .tenant = "acme",
          .map_name = "town",
          .map_version = 3,
          .vehicle = vehicle,
          .identity = "i1",
          .scan_count = 70,
          .size_bytes = 100,
          .first_stamp_ns = 5,
          .last_stamp_ns = 9,
          .sha256 = std::string(64, 'a'),
          .create_time = kNow,
          .expire_time = kNow + hours(24)};
}

class PassRowsTest : public ::testing::TestWithParam<JobImplementation> {
 protected:
  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    rows_ = place_->OpenPasses();
  }

  void Consent() {
    for (const ConsentRow& consent : {kTown, kCar}) {
      ASSERT_TRUE(rows_->GiveConsent("acme", consent).ok());
    }
  }

  absl::Status Add(const PassRow& row) { return rows_->Add(row, "car-1", kQuota); }

  std::unique_ptr<JobPlace> place_;
  std::unique_ptr<PassRows> rows_;
};

TEST_P(PassRowsTest, NothingIsKeptUnlessMapAndIdentityConsent) {
  EXPECT_FALSE(*rows_->MayKeep("acme", "town", "car-1"));
  EXPECT_EQ(Add(PassOf("x")).code(), absl::StatusCode::kPermissionDenied);
  ASSERT_TRUE(rows_->GiveConsent("acme", kTown).ok());
  EXPECT_FALSE(*rows_->MayKeep("acme", "town", "car-1"));
  ASSERT_TRUE(rows_->GiveConsent("acme", kCar).ok());
  ASSERT_TRUE(rows_->GiveConsent("acme", kCar).ok()) << "again";
  EXPECT_TRUE(*rows_->MayKeep("acme", "town", "car-1"));
  EXPECT_FALSE(*rows_->MayKeep("acme", "city", "car-1"));
  EXPECT_FALSE(*rows_->MayKeep("acme", "town", "car-2"));
  EXPECT_FALSE(*rows_->MayKeep("", "town", "car-1")) << "another tenant's";
  EXPECT_TRUE(Add(PassOf("x")).ok());
}

TEST_P(PassRowsTest, WhatIsKeptIsListedNewestFirstAlsoAfterAStart) {
  Consent();
  for (const char* const id : {"x", "y"}) ASSERT_TRUE(Add(PassOf(id)).ok());
  rows_.reset();
  rows_ = place_->OpenPasses();
  const auto passes = *rows_->List("acme", "town", kAny, 10);
  ASSERT_EQ(passes.size(), 2U);
  EXPECT_EQ(passes[0].pass_id, "y");
  const PassRow& first = passes[1];
  EXPECT_EQ(first.pass_id, "x");
  EXPECT_EQ(first.map_version, 3);
  EXPECT_EQ(first.vehicle, "v1");
  EXPECT_EQ(first.scan_count, 70);
  EXPECT_EQ(first.first_stamp_ns, 5);
  EXPECT_EQ(first.last_stamp_ns, 9);
  EXPECT_EQ(first.create_time, kNow);
  EXPECT_EQ(first.expire_time, kNow + hours(24));
  EXPECT_EQ(rows_->List("acme", "town", passes[0].number, 10)->size(), 1U);
  EXPECT_THAT(*rows_->List("", "town", kAny, 10), IsEmpty());
  EXPECT_EQ(*rows_->TotalBytes(), 200);
}

TEST_P(PassRowsTest, AVehicleHasABoundADayAndATenantOneAtAll) {
  Consent();
  for (const char* const id : {"a", "b", "c"}) ASSERT_TRUE(Add(PassOf(id)).ok());
  absl::Status status = Add(PassOf("d"));
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(MessageOf(status), HasSubstr("pass_vehicle_mib_per_day"));
  PassRow later = PassOf("d");
  later.create_time = kNow + hours(25);
  EXPECT_TRUE(Add(later).ok()) << "the next day";
  for (const char* const vehicle : {"v2", "v3"}) {
    for (const char* const id : {"1", "2", "3"}) {
      EXPECT_TRUE(Add(PassOf(std::string(vehicle) + id, vehicle)).ok());
    }
  }
  status = Add(PassOf("e", "v4"));
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(MessageOf(status), HasSubstr("pass_storage_mib"));
}

TEST_P(PassRowsTest, AConsentThatIsWithdrawnTakesWhatWasKeptUnderIt) {
  Consent();
  PassRow other = PassOf("y");
  other.identity = "i2";
  ASSERT_TRUE(Add(PassOf("x")).ok());
  ASSERT_TRUE(Add(other).ok());
  EXPECT_THAT(*rows_->WithdrawConsent("acme", kCar, "i1"), ElementsAre("x"));
  EXPECT_THAT(*rows_->ListIds(), ElementsAre("y"));
  EXPECT_FALSE(*rows_->MayKeep("acme", "town", "car-1"));
  EXPECT_THAT(*rows_->WithdrawConsent("acme", kTown, ""), ElementsAre("y"));
  EXPECT_THAT(*rows_->ListIds(), IsEmpty());
  EXPECT_THAT(*rows_->WithdrawConsent("acme", kTown, ""), IsEmpty()) << "again";
}

TEST_P(PassRowsTest, WhatIsOverGoes) {
  Consent();
  PassRow longer = PassOf("y");
  longer.expire_time = kNow + hours(48);
  ASSERT_TRUE(Add(PassOf("x")).ok());
  ASSERT_TRUE(Add(longer).ok());
  EXPECT_THAT(*rows_->RemoveExpired(kNow + hours(23)), IsEmpty());
  EXPECT_THAT(*rows_->RemoveExpired(kNow + hours(24)), ElementsAre("x"));
  EXPECT_THAT(*rows_->ListIds(), ElementsAre("y"));
}

TEST_P(PassRowsTest, ConsentsAreListedMapsFirst) {
  Consent();
  ASSERT_TRUE(rows_->GiveConsent("acme", {.subject = ConsentSubject::kMap, .name = "city"}).ok());
  ASSERT_TRUE(rows_->GiveConsent("", kTown).ok());
  std::vector<std::string> names;
  const std::vector<ConsentRow> consents = *rows_->ListConsents("acme", 0, 10);
  names.reserve(consents.size());
  for (const ConsentRow& consent : consents) names.push_back(consent.name);
  EXPECT_THAT(names, ElementsAre("city", "town", "car-1"));
  EXPECT_EQ(rows_->ListConsents("acme", 2, 10)->front().subject, ConsentSubject::kIdentity);
}

INSTANTIATE_TEST_SUITE_P(All, PassRowsTest, ::testing::ValuesIn(JobImplementations()),
                         NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
