#include "server/maps/catalogue/build_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/server/fixtures/job_places.h"
#include "tests/server/fixtures/message_of.h"

// What each queue of builds promises.
namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

BuildRow Row(const std::string& build_id, const std::string& tenant = "") {
  return {.build_id = build_id,
          .tenant = tenant,
          .map_name = "town",
          .create_time = SystemTime(std::chrono::seconds(1'700'000'000)),
          .input_sha256 = std::string(64, 'a'),
          .report = std::string("a\0b", 3)};
}

class BuildQueueTest : public ::testing::TestWithParam<JobImplementation> {
 protected:
  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    queue_ = place_->OpenQueue();
  }

  std::string Take(const std::string& holder = "a:1") {
    const auto row = *queue_->Take(holder);
    if (!row) return "";
    lease_ = {.build_id = row->build_id, .holder = holder, .attempt = row->attempt_count};
    return row->build_id;
  }

  BuildState StateOf(const std::string& build_id) { return queue_->Get("", build_id)->state; }

  std::unique_ptr<JobPlace> place_;
  std::unique_ptr<BuildQueue> queue_;
  BuildLease lease_;
};

TEST_P(BuildQueueTest, WhatWasAddedIsThereAlsoAfterAStart) {
  ASSERT_TRUE(queue_->Add(Row("x"), 4).ok());
  queue_.reset();
  queue_ = place_->OpenQueue();
  const auto row = queue_->Get("", "x");
  ASSERT_TRUE(row.ok()) << row.status();
  EXPECT_EQ(row->map_name, "town");
  EXPECT_EQ(row->state, BuildState::kRunning);
  EXPECT_EQ(row->create_time, Row("x").create_time);
  EXPECT_EQ(row->input_sha256, Row("x").input_sha256);
  EXPECT_EQ(row->report, Row("x").report) << "it is bytes";
  EXPECT_EQ(row->attempt_count, 0);
  EXPECT_THAT(*queue_->ListRunning(), ElementsAre("x"));
}

TEST_P(BuildQueueTest, TenantsSeeTheirOwnNewestFirst) {
  for (const char* const id : {"x", "y"}) ASSERT_TRUE(queue_->Add(Row(id), 4).ok());
  ASSERT_TRUE(queue_->Add(Row("z", "acme"), 4).ok());
  std::vector<std::string> ids;
  const std::vector<BuildRow> rows = *queue_->List("");
  ids.reserve(rows.size());
  for (const BuildRow& row : rows) ids.push_back(row.build_id);
  EXPECT_THAT(ids, ElementsAre("y", "x"));
  EXPECT_EQ(queue_->Get("", "z").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(queue_->Cancel("", "z").status().code(), absl::StatusCode::kNotFound);
}

TEST_P(BuildQueueTest, ATenantHasOnlySoManyUnderWay) {
  ASSERT_TRUE(queue_->Add(Row("x"), 1).ok());
  const absl::Status status = queue_->Add(Row("y"), 1);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(MessageOf(status), HasSubstr("1 builds"));
  EXPECT_TRUE(queue_->Add(Row("z", "acme"), 1).ok());
  ASSERT_EQ(Take(), "x");
  EXPECT_TRUE(*queue_->End(lease_, BuildState::kDone, ""));
  EXPECT_TRUE(queue_->Add(Row("y"), 1).ok());
}

TEST_P(BuildQueueTest, EachIsTakenOnceTheOldestFirst) {
  for (const char* const id : {"x", "y"}) ASSERT_TRUE(queue_->Add(Row(id), 4).ok());
  EXPECT_EQ(Take(), "x");
  EXPECT_EQ(lease_.attempt, 1);
  EXPECT_EQ(*queue_->Renew(lease_, "half"), LeaseState::kHeld);
  EXPECT_EQ(queue_->Get("", "x")->report, "half");
  EXPECT_TRUE(*queue_->End(lease_, BuildState::kFailed, "whole"));
  EXPECT_EQ(StateOf("x"), BuildState::kFailed);
  EXPECT_EQ(queue_->Get("", "x")->report, "whole");
  EXPECT_EQ(*queue_->Renew(lease_, "late"), LeaseState::kLost);
  EXPECT_FALSE(*queue_->End(lease_, BuildState::kDone, "late"));
  EXPECT_EQ(Take(), "y");
  EXPECT_TRUE(*queue_->End(lease_, BuildState::kDone, ""));
  EXPECT_EQ(Take(), "");
}

TEST_P(BuildQueueTest, OneThatWaitsIsCancelledAtOnceAndOneThatIsBuiltIsTold) {
  for (const char* const id : {"x", "y"}) ASSERT_TRUE(queue_->Add(Row(id), 4).ok());
  ASSERT_EQ(Take(), "x");
  EXPECT_EQ(queue_->Cancel("", "y")->state, BuildState::kCancelled);
  EXPECT_EQ(queue_->Cancel("", "x")->state, BuildState::kRunning);
  EXPECT_EQ(*queue_->Renew(lease_, ""), LeaseState::kCancelled);
  EXPECT_TRUE(*queue_->End(lease_, BuildState::kCancelled, ""));
  EXPECT_EQ(queue_->Cancel("", "x")->state, BuildState::kCancelled) << "it has ended";
  EXPECT_EQ(Take(), "");
}

TEST_P(BuildQueueTest, WhatIsGivenBackIsTakenAgainAndTheAttemptDoesNotCount) {
  ASSERT_TRUE(queue_->Add(Row("x"), 4).ok());
  ASSERT_EQ(Take(), "x");
  ASSERT_TRUE(queue_->GiveBack(lease_).ok());
  EXPECT_EQ(Take("b:1"), "x");
  EXPECT_EQ(lease_.attempt, 1);
}

TEST_P(BuildQueueTest, WhatItsHolderDroppedIsTakenByItAgain) {
  ASSERT_TRUE(queue_->Add(Row("x"), 4).ok());
  ASSERT_EQ(Take("a:1"), "x");
  const BuildLease dropped = lease_;
  place_->EndLeases();
  EXPECT_EQ(Take("a:1"), "x");
  EXPECT_EQ(lease_.attempt, 2);
  EXPECT_EQ(*queue_->Renew(dropped, ""), LeaseState::kLost);
}

TEST_P(BuildQueueTest, WhatADeadOneHadIsTakenByAnotherAndTheDeadOneHasNoSay) {
  ASSERT_TRUE(queue_->Add(Row("x"), 4).ok());
  ASSERT_EQ(Take("a:1"), "x");
  const BuildLease first = lease_;
  place_->EndLeases();
  ASSERT_EQ(Take("b:1"), "x");
  EXPECT_EQ(lease_.attempt, 2);
  EXPECT_EQ(*queue_->Renew(first, ""), LeaseState::kLost);
  EXPECT_FALSE(*queue_->End(first, BuildState::kDone, ""));
  ASSERT_TRUE(queue_->GiveBack(first).ok());
  EXPECT_EQ(*queue_->Renew(lease_, ""), LeaseState::kHeld);
}

TEST_P(BuildQueueTest, OneThatWasCancelledIsNotTakenOverFromADeadOne) {
  ASSERT_TRUE(queue_->Add(Row("x"), 4).ok());
  ASSERT_EQ(Take("a:1"), "x");
  ASSERT_TRUE(queue_->Cancel("", "x").ok());
  place_->EndLeases();
  EXPECT_EQ(Take("b:1"), "");
  EXPECT_EQ(StateOf("x"), BuildState::kCancelled);
}

TEST_P(BuildQueueTest, OnlyTheLastOnesThatEndedAreKept) {
  for (int i = 0; i < BuildQueue::kMaxEnded + 3; ++i) {
    ASSERT_TRUE(queue_->Add(Row(absl::StrCat("x", i)), 1).ok());
    ASSERT_EQ(Take(), absl::StrCat("x", i));
    ASSERT_TRUE(*queue_->End(lease_, BuildState::kDone, ""));
  }
  ASSERT_TRUE(queue_->Add(Row("last"), 1).ok());
  EXPECT_EQ(queue_->List("")->size(), static_cast<std::size_t>(BuildQueue::kMaxEnded) + 1);
  EXPECT_EQ(queue_->Get("", "x2").status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(queue_->Get("", "x3").ok());
}

INSTANTIATE_TEST_SUITE_P(All, BuildQueueTest, ::testing::ValuesIn(JobImplementations()),
                         NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
