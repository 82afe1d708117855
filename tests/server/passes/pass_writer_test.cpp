#include "server/passes/pass_writer.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/server/fixtures/eventually.h"
#include "tests/server/passes/pass_fixture.h"

namespace dcloc::server {
namespace {

class PassWriterTest : public ::testing::Test {
 protected:
  PassWriterTest() {
    std::filesystem::create_directory(passes_.folder.path() / "incoming");
    writer_ = std::make_unique<PassWriter>(*passes_.store, passes_.folder.path() / "incoming",
                                           [this] { return bounds_; });
  }

  static PassChunk Chunk(std::int64_t scan_count, std::size_t size = 100) {
    return {.bytes = std::string(size, 'x'),
            .scan_count = scan_count,
            .first_stamp_ns = 10,
            .last_stamp_ns = 20};
  }

  bool NothingIsLeft() const {
    return std::filesystem::is_empty(passes_.folder.path() / "incoming");
  }

  TestPasses passes_;
  PassBounds bounds_ = kWideBounds;
  std::unique_ptr<PassWriter> writer_;
};

TEST_F(PassWriterTest, KeepsWhatWasHandedOverAlsoWhenItEnds) {
  auto pass = writer_->Begin(TownPass());
  EXPECT_TRUE(writer_->Append(pass, Chunk(40)));
  EXPECT_TRUE(writer_->Append(pass, Chunk(20)));
  writer_->End(pass);
  pass.reset();
  writer_.reset();
  const auto list = passes_.List();
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].scan_count, 60);
  EXPECT_EQ(list[0].size_bytes, 200);
  EXPECT_EQ(list[0].first_stamp_ns, 10);
  EXPECT_EQ(list[0].last_stamp_ns, 20);
  EXPECT_TRUE(passes_.store->Fetch(list[0], passes_.folder.path() / "copy").ok());
  EXPECT_TRUE(NothingIsLeft());
}

TEST_F(PassWriterTest, WhatIsShortOverTheQuotaOrWithoutConsentIsNotKept) {
  const auto keep = [&](std::int64_t scan_count) {
    auto pass = writer_->Begin(TownPass());
    EXPECT_TRUE(writer_->Append(pass, Chunk(scan_count)));
    writer_->End(pass);
  };
  const PassCounts& counts = writer_->counts();
  keep(PassWriter::kMinScanCount - 1);
  EXPECT_TRUE(Eventually([&] { return counts.too_short == 1; }));
  bounds_.quota.max_vehicle_bytes_per_day = 10;
  keep(60);
  EXPECT_TRUE(Eventually([&] { return counts.over_quota == 1; }));
  passes_.store->WithdrawConsent("", {.subject = ConsentSubject::kMap, .name = "town"})
      .IgnoreError();
  keep(60);
  EXPECT_TRUE(Eventually([&] { return counts.withdrawn == 1; }));
  EXPECT_TRUE(Eventually([&] { return NothingIsLeft(); }));
  EXPECT_EQ(passes_.FileCount(), 0U);
  EXPECT_EQ(counts.kept, 0);
}

TEST_F(PassWriterTest, WhoComesWhileTooMuchWaitsIsTurnedAwayAndDoesNotWait) {
  auto pass = writer_->Begin(TownPass());
  EXPECT_FALSE(writer_->Append(pass, Chunk(7, PassWriter::kMaxWaiting_bytes + 1)));
  EXPECT_EQ(writer_->counts().dropped_scans, 7);
  EXPECT_TRUE(writer_->Append(pass, Chunk(60))) << "there is room for less";
}

TEST_F(PassWriterTest, APassThatIsGivenUpLeavesNothing) {
  auto pass = writer_->Begin(TownPass());
  EXPECT_TRUE(writer_->Append(pass, Chunk(60)));
  EXPECT_TRUE(Eventually([&] { return !NothingIsLeft(); }));
  pass.reset();
  writer_.reset();
  EXPECT_TRUE(NothingIsLeft());
  EXPECT_TRUE(passes_.List().empty());
}

}  // namespace
}  // namespace dcloc::server
