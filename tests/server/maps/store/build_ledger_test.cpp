#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "server/maps/jobs/map_builds.h"
#include "server/maps/store/build_ledger.h"
#include "tests/server/fixtures/town_drive.h"
#include "tests/server/maps/store/map_store_fixture.h"

// What a server says of builds that were under way when it was ended.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class BuildLedgerTest : public StoreFixture {
 protected:
  std::filesystem::path Folder() const { return folder_.path() / "builds"; }

  static LedgerEntry Entry(const std::string& build_id, int second) {
    return {.tenant = "acme",
            .build_id = build_id,
            .map_name = "town",
            .scan_count = 7,
            .create_time = SystemTime(std::chrono::seconds(second))};
  }
};

TEST_F(BuildLedgerTest, AnInterruptedBuildHasFailedAfterTheRestart) {
  ASSERT_TRUE(store_->builds().Add(Entry("0b", 2)).ok());
  ASSERT_TRUE(store_->builds().Add(Entry("0a", 1)).ok());
  ASSERT_TRUE(store_->builds().Add(Entry("0c", 3)).ok());
  store_->builds().Remove("0c");
  Reopen();
  MapBuilds builds(*store_);
  const std::vector<BuildRecord> list = builds.List("acme");
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0].build_id, "0b") << "newest first";
  const absl::StatusOr<BuildRecord> record = builds.Get("acme", "0a");
  ASSERT_TRUE(record.ok()) << record.status();
  EXPECT_EQ(record->state, BuildState::kFailed);
  EXPECT_EQ(record->error.code(), absl::StatusCode::kAborted);
  EXPECT_THAT(std::string(record->error.message()), HasSubstr("restarted"));
  EXPECT_EQ(record->map_name, "town");
  EXPECT_EQ(record->scan_count, 7);
  EXPECT_EQ(record->create_time, SystemTime(std::chrono::seconds(1)));
  EXPECT_EQ(builds.Get("", "0a").status().code(), absl::StatusCode::kNotFound)
      << "another tenant's";
  EXPECT_TRUE(builds.Cancel("acme", "0a").ok()) << "which does nothing";
}

TEST_F(BuildLedgerTest, WhatACrashLeftHalfWrittenIsRemoved) {
  std::ofstream(Folder() / "0d") << "acme\ntown\n7\n170";
  std::ofstream(Folder() / "0e") << "acme\nto";
  Reopen();
  EXPECT_TRUE(store_->builds().interrupted().empty());
  EXPECT_TRUE(std::filesystem::is_empty(Folder()));
}

TEST_F(BuildLedgerTest, TheEndOfTheServerInterruptsABuildAndItsOwnEndDoesNot) {
  const TownDrive drive(60.0);
  const auto start = [&](MapBuilds& builds) {
    auto scans = *ScanSpool::Create(store_->incoming().folder());
    for (std::size_t i = 0; i < drive.mapping.scans.size(); ++i) {
      v1::PosedScan scan;
      *scan.mutable_scan() = MessageOf(drive.mapping.scans[i].scan, static_cast<std::int64_t>(i));
      convert::ToProto(drive.mapping.scans[i].T_map_vehicle, scan.mutable_t_map_vehicle());
      EXPECT_TRUE(scans->Append(scan, std::int64_t{1} << 30).ok());
    }
    const auto record = builds.Start(
        {.map_name = "town", .rig = drive.mapping.rig, .limits = kNoLimits}, std::move(scans));
    EXPECT_TRUE(record.ok()) << record.status();
    return record->build_id;
  };
  {
    MapBuilds builds(*store_);
    const std::string cancelled = start(builds);
    EXPECT_TRUE(builds.Cancel("", cancelled).ok());
    while (builds.Get("", cancelled)->state == BuildState::kRunning) {
    }
    EXPECT_TRUE(std::filesystem::is_empty(Folder())) << "a client's wish";
    for (int i = 0; i < 4; ++i) start(builds);
  }
  EXPECT_FALSE(std::filesystem::is_empty(Folder())) << "the last of them had no time";
  Reopen();
  EXPECT_FALSE(store_->builds().interrupted().empty());
}

}  // namespace
}  // namespace dcloc::server
