#include "server/app/store_backup.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

bool GoOn(const StoreProgress& /*progress*/) { return true; }

class StoreBackupTest : public StoreFixture {
 protected:
  StoreBackupTest() {
    Put(first_);
    Put(second_);
  }

  std::filesystem::path InBackup(const std::vector<std::byte>& bytes) const {
    const std::string sha256 = Sha256Of(bytes);
    return backup_ / "maps" / sha256.substr(0, 2) / (sha256 + ".dcmap");
  }

  /// Lets what was opened be used at once.
  std::string ActiveName() {
    const absl::StatusOr<LoadedMap> map = store_->Acquire("town", 0);
    return map.ok() ? map->map->info().name : std::string(map.status().message());
  }

  const std::vector<std::byte> first_ = SmallMap("first");
  const std::vector<std::byte> second_ = SmallMap("second");
  const TemporaryFolder elsewhere_;
  const std::filesystem::path backup_ = elsewhere_.path() / "backup";
};

TEST_F(StoreBackupTest, IsMadeBesideAServerAndRestoredIntoAnEmptyFolder) {
  const absl::StatusOr<BackupReport> made = BackUpStore(folder_.path(), backup_, GoOn);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->file_count, 2);
  EXPECT_EQ(made->copied_count, 2);
  const std::filesystem::path anew = elsewhere_.path() / "anew";
  const absl::StatusOr<BackupReport> restored = RestoreStore(backup_, anew, GoOn);
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->copied_count, 2);
  const absl::StatusOr<Storage> storage = OpenStorage(anew);
  ASSERT_TRUE(storage.ok()) << storage.status();
  EXPECT_EQ(storage->maps->Acquire("town", 0)->map->info().name, "second");
  EXPECT_EQ(storage->maps->Acquire("town", 1)->map->info().name, "first");
}

TEST_F(StoreBackupTest, ASecondOneCopiesWhatIsNewAndForgetsWhatIsGone) {
  ASSERT_TRUE(BackUpStore(folder_.path(), backup_, GoOn).ok());
  ASSERT_TRUE(store_->DeleteVersion("town", 1).ok());
  const std::vector<std::byte> third = SmallMap("third");
  Put(third);
  const absl::StatusOr<BackupReport> again = BackUpStore(folder_.path(), backup_, GoOn);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->copied_count, 1);
  EXPECT_FALSE(std::filesystem::exists(InBackup(first_)));
  EXPECT_TRUE(std::filesystem::exists(InBackup(third)));
}

TEST_F(StoreBackupTest, DoesNotReplaceAnotherServersStore) {
  const std::filesystem::path other = elsewhere_.path() / "other";
  ASSERT_TRUE(OpenStorage(other).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(BackUpStore(folder_.path(), other, GoOn).status()));
  EXPECT_TRUE(OpenStorage(other)->maps->Acquire("town", 0).status().code() ==
              absl::StatusCode::kNotFound);
}

TEST_F(StoreBackupTest, StoreAndBackupAreTwoFolders) {
  Close();
  const std::filesystem::path link = elsewhere_.path() / "link";
  std::filesystem::create_symlink(folder_.path(), link);
  EXPECT_TRUE(absl::IsInvalidArgument(BackUpStore(folder_.path(), link, GoOn).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(RestoreStore(link, folder_.path(), GoOn).status()));
  EXPECT_TRUE(OpenStorage(folder_.path()).ok());
}

TEST_F(StoreBackupTest, OfAFolderThatIsNoStoreMakesNothing) {
  EXPECT_TRUE(absl::IsNotFound(BackUpStore(elsewhere_.path(), backup_, GoOn).status()));
  EXPECT_FALSE(std::filesystem::exists(backup_));
}

TEST_F(StoreBackupTest, StoppedItLeavesTheOldBackupAsItWas) {
  ASSERT_TRUE(BackUpStore(folder_.path(), backup_, GoOn).ok());
  Put(SmallMap("third"));
  EXPECT_TRUE(absl::IsCancelled(
      BackUpStore(folder_.path(), backup_, [](const StoreProgress&) { return false; }).status()));
  const std::filesystem::path anew = elsewhere_.path() / "anew";
  ASSERT_TRUE(RestoreStore(backup_, anew, GoOn).ok());
  EXPECT_EQ(OpenStorage(anew)->maps->Acquire("town", 0)->map->info().name, "second");
}

TEST_F(StoreBackupTest, LeavesOutADamagedFileAndSaysSo) {
  std::fstream(FileOf(first_), std::ios::in | std::ios::out | std::ios::binary).put('?');
  const absl::StatusOr<BackupReport> made = BackUpStore(folder_.path(), backup_, GoOn);
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_EQ(made->damaged_files, std::vector<std::string>{Sha256Of(first_)});
  EXPECT_FALSE(std::filesystem::exists(InBackup(first_)));
}

TEST_F(StoreBackupTest, TheStoresOwnFolderIsRefused) {
  Close();
  EXPECT_EQ(BackUpStore(folder_.path(), folder_.path(), GoOn).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(StoreBackupTest, RestoredOverAStoreItLosesNothingThatIsThere) {
  ASSERT_TRUE(BackUpStore(folder_.path(), backup_, GoOn).ok());
  const std::vector<std::byte> third = SmallMap("third");
  Put(third);
  EXPECT_EQ(RestoreStore(backup_, folder_.path(), GoOn).status().code(),
            absl::StatusCode::kFailedPrecondition)
      << "a server has it";
  Close();
  const absl::StatusOr<BackupReport> restored = RestoreStore(backup_, folder_.path(), GoOn);
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->copied_count, 0) << "they were there, whole";
  Reopen();
  EXPECT_EQ(ActiveName(), "second");
  EXPECT_EQ(*store_->files().QuarantinedCount(), 1) << "the third one";
}

TEST_F(StoreBackupTest, RestoresALostCatalogueAndADamagedFile) {
  ASSERT_TRUE(BackUpStore(folder_.path(), backup_, GoOn).ok());
  Close();
  std::filesystem::remove(folder_.path() / "catalogue.sqlite");
  std::fstream(FileOf(second_), std::ios::in | std::ios::out | std::ios::binary).put('?');
  const absl::StatusOr<BackupReport> restored = RestoreStore(backup_, folder_.path(), GoOn);
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ(restored->copied_count, 1);
  Reopen();
  EXPECT_EQ(ActiveName(), "second");
}

TEST_F(StoreBackupTest, ADamagedOneOrAStopChangesNothing) {
  ASSERT_TRUE(BackUpStore(folder_.path(), backup_, GoOn).ok());
  const std::filesystem::path anew = elsewhere_.path() / "anew";
  EXPECT_TRUE(absl::IsCancelled(
      RestoreStore(backup_, anew, [](const StoreProgress&) { return false; }).status()));
  std::fstream(InBackup(first_), std::ios::in | std::ios::out | std::ios::binary).put('?');
  EXPECT_TRUE(absl::IsDataLoss(RestoreStore(backup_, anew, GoOn).status()));
  EXPECT_FALSE(std::filesystem::exists(anew / "catalogue.sqlite"));
  EXPECT_FALSE(std::filesystem::exists(anew / "restoring"));
  EXPECT_EQ(OpenStorage(anew)->maps->catalogue().ListFiles()->size(), 0U);
}

}  // namespace
}  // namespace dcloc::server
