#include "client/sdk/ticket_keeper.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

class TicketKeeperTest : public ::testing::Test {
 protected:
  TicketKeeperTest() { Opened(1, true); }

  void Opened(std::int64_t epoch, bool hands_out_tickets,
              v1::TicketUse use = v1::TICKET_USE_UNSPECIFIED) {
    v1::SessionOpened opened;
    opened.set_epoch(epoch);
    opened.set_ticket_use(use);
    if (hands_out_tickets) opened.set_ticket_interval_ns(1'000'000'000);
    keeper_.OnOpened(opened);
  }

  /// With a ticket of scan `ticket` where that is not negative.
  void Answered(std::int64_t number, std::int64_t ticket = -1) {
    v1::Scan scan;
    scan.set_sequence_number(number);
    v1::LocalizeResponse answer;
    answer.mutable_result()->set_sequence_number(number);
    if (ticket >= 0) {
      answer.mutable_ticket()->set_sealed(absl::StrCat("ticket of ", ticket));
      answer.mutable_ticket()->set_last_sequence_number(ticket);
    }
    keeper_.OnAnswered(scan, answer);
  }

  v1::OpenSession Open() const {
    v1::OpenSession open;
    keeper_.Apply(&open);
    return open;
  }

  std::vector<std::int64_t> ScansAfter(std::int64_t number) const {
    std::vector<std::int64_t> numbers;
    std::size_t index = 0;
    while (const v1::Scan* scan = keeper_.Next(number, &index)) {
      numbers.push_back(scan->sequence_number());
    }
    return numbers;
  }

  TicketKeeper keeper_;
};

TEST_F(TicketKeeperTest, KeepsTheNewestTicketAndTheScansSinceThen) {
  for (int i = 0; i < 5; ++i) Answered(i);
  EXPECT_FALSE(keeper_.has_ticket());
  Answered(5, 2);
  EXPECT_EQ(ScansAfter(2), (std::vector<std::int64_t>{3, 4, 5}));
  Answered(6, 4);
  EXPECT_EQ(Open().ticket(), "ticket of 4");
  EXPECT_EQ(Open().answered_sequence_number(), 6);
  EXPECT_EQ(ScansAfter(4), (std::vector<std::int64_t>{5, 6}));
  EXPECT_EQ(ScansAfter(5), (std::vector<std::int64_t>{6}));
}

TEST_F(TicketKeeperTest, ARejectedScanHidesNoneThatIsStillUnanswered) {
  Answered(0, 0);
  Answered(1);
  v1::Scan scan;
  scan.set_sequence_number(3);
  v1::LocalizeResponse answer;
  answer.mutable_rejected()->set_sequence_number(3);
  keeper_.OnAnswered(scan, answer);
  EXPECT_EQ(Open().answered_sequence_number(), 1) << "2 may come yet";
}

TEST_F(TicketKeeperTest, KeepsNothingOfAServerThatHandsOutNone) {
  Opened(2, false);
  Answered(0);
  EXPECT_TRUE(ScansAfter(-1).empty());
  EXPECT_FALSE(keeper_.has_ticket());
  EXPECT_EQ(Open().epoch(), 2);
}

TEST_F(TicketKeeperTest, ATicketIsWorthNothingOnceItsScansAreTooMany) {
  Answered(0, 0);
  const auto count = static_cast<std::int64_t>(TicketKeeper::kMaxScanCount);
  for (std::int64_t i = 1; i <= count; ++i) Answered(i);
  EXPECT_TRUE(keeper_.has_ticket());
  Answered(count + 1);
  EXPECT_FALSE(keeper_.has_ticket());
  EXPECT_FALSE(Open().has_answered_sequence_number());
  EXPECT_EQ(ScansAfter(0).size(), TicketKeeper::kMaxScanCount);
}

TEST_F(TicketKeeperTest, SurvivesAServerThatGoesOnFromItAndNotOneThatBeginsAnew) {
  Answered(0, 0);
  Answered(1);
  Opened(2, true, v1::TICKET_USE_ACCEPTED);
  EXPECT_TRUE(keeper_.has_ticket()) << "until the new server has made one";
  Opened(3, true, v1::TICKET_USE_EXPIRED);
  EXPECT_FALSE(keeper_.has_ticket());
  EXPECT_TRUE(ScansAfter(-1).empty());
}

TEST_F(TicketKeeperTest, ItsEpochOnlyRises) {
  Opened(7, true);
  Opened(0, false);
  EXPECT_EQ(keeper_.epoch(), 7) << "an older server tells none";
}

}  // namespace
}  // namespace dcloc::client
