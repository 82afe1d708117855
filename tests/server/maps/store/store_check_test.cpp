#include "server/maps/store/store_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/map_folder.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

/// A catalogue and map files that this process shares with another one.
class StoreCheckTest : public ::testing::Test {
 protected:
  void WriteMapFile(const std::string& sha256) const {
    const std::filesystem::path folder = folder_.path() / "maps" / sha256.substr(0, 2);
    std::filesystem::create_directories(folder);
    std::ofstream(folder / (sha256 + ".dcmap")) << "a map";
  }

  absl::StatusOr<StoreReport> Check() const {
    return CheckStore(*catalogue_, *files_, *incoming_, std::chrono::hours(24), "this:1");
  }

  int QuarantinedCount() const {
    const absl::StatusOr<StoreReport> report = Check();
    EXPECT_TRUE(report.ok()) << report.status();
    EXPECT_TRUE(catalogue_->ListLooseFiles()->empty() || report->quarantined_file_count == 0);
    return report->quarantined_file_count;
  }

  const std::string sha256_ = std::string(64, 'a');
  TemporaryFolder folder_;
  const std::unique_ptr<Catalogue> catalogue_ =
      *SqliteCatalogue::Open(folder_.path() / "catalogue.sqlite");
  const std::unique_ptr<MapFiles> files_ =
      *MapFolder::Open(folder_.path() / "maps", folder_.path() / "quarantine");
  const std::unique_ptr<IncomingFiles> incoming_ =
      *IncomingFiles::Open(folder_.path() / "incoming");
};

TEST_F(StoreCheckTest, WhatACrashLeftIsSetAsideAndWhatHasAVersionIsNot) {
  const std::string left(64, 'b');
  const std::string never_came(64, 'c');
  WriteMapFile(sha256_);
  ASSERT_TRUE(catalogue_->AddLooseFile(left).ok());
  ASSERT_TRUE(catalogue_->AddLooseFile(never_came).ok());
  WriteMapFile(left);
  ASSERT_TRUE(catalogue_->AddVersion("town", sha256_, {}, {}).ok());
  EXPECT_EQ(QuarantinedCount(), 1);
  EXPECT_EQ(*files_->List(), std::vector<std::string>{sha256_});
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "quarantine" / (left + ".dcmap")));
  EXPECT_TRUE(catalogue_->ListLooseFiles()->empty());
}

TEST_F(StoreCheckTest, AFileThatAnotherProcessIsStoringIsLeftAlone) {
  absl::StatusOr<Hold> other = catalogue_->HoldFile(sha256_, "other:1");
  ASSERT_TRUE(other.ok()) << other.status();
  ASSERT_TRUE(catalogue_->AddLooseFile(sha256_).ok());
  WriteMapFile(sha256_);
  EXPECT_EQ(QuarantinedCount(), 0);
  EXPECT_EQ(files_->List()->size(), 1U);
  *other = Hold();  // it has died before it could add its version
  EXPECT_EQ(QuarantinedCount(), 1);
  EXPECT_TRUE(files_->List()->empty());
}

TEST_F(StoreCheckTest, WhatADeadProcessHeldIsSetAsideLater) {
  absl::StatusOr<Hold> of_the_dead = catalogue_->HoldFile(sha256_, "other:1");
  ASSERT_TRUE(of_the_dead.ok()) << of_the_dead.status();
  ASSERT_TRUE(catalogue_->AddLooseFile(sha256_).ok());
  WriteMapFile(sha256_);
  EXPECT_EQ(SetLooseFilesAside(*catalogue_, *files_, "this:1").value_or(-1), 0);
  *of_the_dead = Hold();  // its lease is over
  EXPECT_EQ(SetLooseFilesAside(*catalogue_, *files_, "this:1").value_or(-1), 1);
  EXPECT_TRUE(files_->List()->empty());
  EXPECT_EQ(SetLooseFilesAside(*catalogue_, *files_, "this:1").value_or(-1), 0);
}

TEST_F(StoreCheckTest, FilesOfWhichTheCatalogueKnowsNothingAreAnErrorAndStay) {
  ASSERT_TRUE(catalogue_->AddVersion("town", sha256_, {}, {}).ok());
  const std::string unknown(64, 'd');
  WriteMapFile(sha256_);
  WriteMapFile(unknown);
  const absl::Status status = Check().status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr(unknown));
  EXPECT_EQ(files_->List()->size(), 2U);
  EXPECT_EQ(*files_->QuarantinedCount(), 0);
}

TEST_F(StoreCheckTest, WhatADeletionLeftIsKnown) {
  ASSERT_TRUE(catalogue_->AddVersion("town", sha256_, {}, {}).ok());
  ASSERT_TRUE(catalogue_->AddVersion("city", sha256_, {}, {}).ok());
  WriteMapFile(sha256_);
  ASSERT_TRUE(catalogue_->DeleteMap("town").ok());
  EXPECT_TRUE(catalogue_->ListLooseFiles()->empty()) << "another map has it";
  ASSERT_TRUE(catalogue_->DeleteVersion("city", 1).ok());
  EXPECT_EQ(*catalogue_->ListLooseFiles(), std::vector<std::string>{sha256_});
  EXPECT_EQ(QuarantinedCount(), 1);
}

TEST_F(StoreCheckTest, ACatalogueThatCannotBeChangedIsNoReasonNotToStart) {
  ASSERT_TRUE(catalogue_->AddLooseFile(sha256_).ok());
  WriteMapFile(sha256_);
  absl::StatusOr<SqliteDatabase> other = SqliteDatabase::Open(folder_.path() / "catalogue.sqlite");
  ASSERT_TRUE(other->Run("BEGIN IMMEDIATE").ok());
  EXPECT_TRUE(Check().ok());
  ASSERT_TRUE(other->Run("ROLLBACK").ok());
  EXPECT_TRUE(Check().ok());
  EXPECT_TRUE(catalogue_->ListLooseFiles()->empty());
  EXPECT_EQ(*files_->QuarantinedCount(), 1);
}

TEST_F(StoreCheckTest, QuarantineEndsAfterItsTime) {
  WriteMapFile(sha256_);
  ASSERT_TRUE(files_->Quarantine(sha256_).ok());
  using std::chrono::hours;
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(1), hours(2)), 0);
  const auto long_ago = std::filesystem::file_time_type::clock::now() - hours(24 * 365);
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "quarantine")) {
    std::filesystem::last_write_time(entry.path(), long_ago);
  }
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(1), hours(2)), 0) << "clocks do not count";
  EXPECT_EQ(*files_->QuarantinedCount(), 1);
  EXPECT_EQ(*files_->RemoveExpiredQuarantine(hours(1), hours(2)), 1);
  EXPECT_EQ(*files_->QuarantinedCount(), 0);
}

}  // namespace
}  // namespace dcloc::server
