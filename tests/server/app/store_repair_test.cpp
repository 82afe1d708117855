#include "server/app/store_repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/sqlite.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class StoreRepairTest : public StoreFixture {
 protected:
  StoreRepairTest() {
    Put(bytes_);
    Close();
  }

  absl::StatusOr<RepairReport> Repair(bool adopt = false) {
    return RepairStore(folder_.path(), {.adopt = adopt}, [](const StoreProgress&) { return true; });
  }

  int AsideCount() const {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      count += entry.path().filename().string().starts_with("catalogue.sqlite.aside-") ? 1 : 0;
    }
    return count;
  }

  const std::vector<std::byte> bytes_ = SmallMap();
  const std::filesystem::path catalogue_ = folder_.path() / "catalogue.sqlite";
};

TEST_F(StoreRepairTest, LeavesAWholeStoreAsItIs) {
  const absl::StatusOr<RepairReport> report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_FALSE(report->catalogue_replaced);
  EXPECT_TRUE(report->audit.ok());
  Reopen();
  EXPECT_TRUE(store_->Acquire("town", 0).ok());
}

TEST_F(StoreRepairTest, SetsFilesAsideWhoseCatalogueIsLost) {
  std::filesystem::remove(catalogue_);
  const absl::StatusOr<RepairReport> report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->quarantined_count, 1);
  Reopen();
  EXPECT_EQ(*store_->files().QuarantinedCount(), 1);
}

TEST_F(StoreRepairTest, MakesMapsOfThemIfAskedTo) {
  std::filesystem::remove(catalogue_);
  const absl::StatusOr<RepairReport> report = Repair(/*adopt=*/true);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->adopted_count, 1);
  Reopen();
  const std::string name = "recovered-" + Sha256Of(bytes_).substr(0, 12);
  EXPECT_TRUE(store_->Acquire(name, 1).ok());
  EXPECT_EQ(store_->Acquire(name, 0).status().code(), absl::StatusCode::kFailedPrecondition)
      << "not active";
}

TEST_F(StoreRepairTest, KeepsACatalogueThatIsNoDatabaseBesideTheNewOne) {
  std::ofstream(catalogue_, std::ios::trunc) << std::string(4096, 'x');
  const absl::StatusOr<RepairReport> report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_TRUE(report->catalogue_replaced);
  EXPECT_EQ(AsideCount(), 1);
}

TEST_F(StoreRepairTest, KeepsBuildsAndPassesThatAreNoDatabaseAside) {
  for (const char* name : {"jobs.sqlite", "passes.sqlite"}) {
    std::filesystem::remove(folder_.path() / absl::StrCat(name, "-wal"));
    std::ofstream(folder_.path() / name, std::ios::trunc) << std::string(4096, 'x');
  }
  EXPECT_THAT(MessageOf(OpenStorage(folder_.path()).status()),
              AllOf(HasSubstr("jobs.sqlite"), HasSubstr("store repair")));
  const absl::StatusOr<RepairReport> report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_THAT(report->set_aside, ElementsAre("jobs.sqlite", "passes.sqlite"));
  EXPECT_FALSE(report->catalogue_replaced);
  Reopen();
  EXPECT_TRUE(store_->Acquire("town", 0).ok());
}

TEST_F(StoreRepairTest, LeavesAFolderThatIsNoStoreAsItIs) {
  const TemporaryFolder other;
  EXPECT_TRUE(absl::IsNotFound(
      RepairStore(other.path(), {}, [](const StoreProgress&) { return true; }).status()));
  EXPECT_TRUE(std::filesystem::is_empty(other.path()));
}

TEST_F(StoreRepairTest, LeavesANewerProgramsCatalogueAlone) {
  ASSERT_TRUE(SqliteDatabase::Open(catalogue_)->Run("PRAGMA user_version = 99").ok());
  EXPECT_EQ(Repair().status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(AsideCount(), 0);
}

TEST_F(StoreRepairTest, SaysWhatIsDamaged) {
  std::fstream(FileOf(bytes_), std::ios::in | std::ios::out | std::ios::binary).put('?');
  const absl::StatusOr<RepairReport> report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_EQ(report->audit.damaged_files, std::vector<std::string>{Sha256Of(bytes_)});
}

TEST_F(StoreRepairTest, AServersStoreIsLeftAlone) {
  Reopen();
  EXPECT_EQ(Repair().status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace dcloc::server
