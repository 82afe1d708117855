#include "server/app/storage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/base/sqlite.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class StorageTest : public StoreFixture {};

TEST_F(StorageTest, OneFolderServesOneStore) {
  const absl::Status status = OpenStorage(folder_.path()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), HasSubstr(folder_.path().string()));
}

TEST_F(StorageTest, ACatalogueThatIsNoDatabaseIsAnError) {
  Close();
  std::filesystem::remove(folder_.path() / "catalogue.sqlite-wal");
  std::ofstream(folder_.path() / "catalogue.sqlite", std::ios::trunc) << std::string(4096, 'x');
  EXPECT_EQ(OpenStorage(folder_.path()).status().code(), absl::StatusCode::kDataLoss);
}

// A pipe, a folder, or a link in place of a map file: that map is damaged, and no other.
TEST_F(StorageTest, WhatIsNoFileInPlaceOfAMapIsDamageThatAnUploadMends) {
  const std::vector<std::byte> bytes = SmallMap();
  Put(bytes);
  const std::filesystem::path file = FileOf(bytes);
  const std::vector<std::function<void()>> things = {
      [&] { ASSERT_EQ(mkfifo(file.c_str(), 0600), 0); },
      [&] { std::filesystem::create_directories(file / "inner"); },
      [&] { std::filesystem::create_symlink(file.filename(), file); },
      [&] { std::filesystem::create_symlink("/dev/zero", file); }};
  for (const auto& put : things) {
    Close();
    std::filesystem::remove(file);
    put();
    Reopen();
    EXPECT_EQ(store_->Acquire("town", 0).status().code(), absl::StatusCode::kDataLoss);
    Put(bytes);
    EXPECT_TRUE(store_->Acquire("town", 0).ok());
  }
}

TEST_F(StorageTest, APipeInPlaceOfADatabaseIsRefused) {
  Close();
  for (const char* name : {"catalogue.sqlite", "identities.sqlite", "jobs.sqlite"}) {
    const std::filesystem::path path = folder_.path() / name;
    const std::filesystem::path kept = folder_.path() / "kept";
    std::filesystem::rename(path, kept);
    ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
    const absl::Status status = OpenStorage(folder_.path()).status();
    EXPECT_THAT(MessageOf(status), AllOf(HasSubstr(name), HasSubstr("not a regular file")));
    std::filesystem::rename(kept, path);
  }
  EXPECT_TRUE(OpenStorage(folder_.path()).ok());
}

class CatalogueLostTest : public StoreFixture {
 protected:
  CatalogueLostTest() {
    Put(bytes_);
    Close();
  }

  /// That the store is refused, with all of these in the message, and that its map file stays.
  void ExpectRefused(absl::StatusCode code, const std::string& reason) const {
    const absl::Status status = OpenStorage(folder_.path()).status();
    EXPECT_EQ(status.code(), code) << status;
    EXPECT_THAT(MessageOf(status), AllOf(HasSubstr(reason), HasSubstr("store restore"),
                                         HasSubstr(folder_.path().string())));
    EXPECT_TRUE(std::filesystem::exists(FileOf(bytes_)));
  }

  const std::vector<std::byte> bytes_ = SmallMap();
  const std::filesystem::path catalogue_ = folder_.path() / "catalogue.sqlite";
};

TEST_F(CatalogueLostTest, AMissingOneIsNotMadeAnew) {
  std::filesystem::remove(catalogue_);
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "1 map files");
  EXPECT_FALSE(std::filesystem::exists(catalogue_));
}

TEST_F(CatalogueLostTest, AnEmptyOneIsRefused) {
  std::filesystem::resize_file(catalogue_, 0);
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "missing or empty");
}

TEST_F(CatalogueLostTest, AnOlderOneIsRefused) {
  const std::filesystem::path older = folder_.path() / "older";
  std::filesystem::copy_file(catalogue_, older);
  Reopen();
  Put(SmallMap("second"));
  Close();
  std::filesystem::rename(older, catalogue_);
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "knows nothing of 1");
  EXPECT_TRUE(std::filesystem::exists(FileOf(SmallMap("second"))));
}

TEST_F(CatalogueLostTest, ANewerOneIsRefused) {
  ASSERT_TRUE(SqliteDatabase::Open(catalogue_)->Run("PRAGMA user_version = 99").ok());
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "99");
}

TEST_F(CatalogueLostTest, AnotherProgramsDatabaseIsRefusedUnchanged) {
  std::filesystem::remove(catalogue_);
  ASSERT_TRUE(SqliteDatabase::Open(catalogue_)->Run("CREATE TABLE song (name TEXT)").ok());
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "something else");
  std::filesystem::copy_file(folder_.path() / "identities.sqlite", catalogue_,
                             std::filesystem::copy_options::overwrite_existing);
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "something else");
}

TEST_F(CatalogueLostTest, OneOfAnotherStoreIsRefused) {
  const TemporaryFolder other;
  ASSERT_TRUE(OpenStorage(other.path()).ok());
  std::filesystem::copy_file(other.path() / "catalogue.sqlite", catalogue_,
                             std::filesystem::copy_options::overwrite_existing);
  ExpectRefused(absl::StatusCode::kFailedPrecondition, "knows nothing of 1");
}

TEST_F(StorageTest, IsItsOwnersAlone) {
  Close();
  std::filesystem::permissions(folder_.path(), std::filesystem::perms(0755));
  std::filesystem::permissions(folder_.path() / "catalogue.sqlite", std::filesystem::perms(0644));
  Reopen();
  EXPECT_EQ(std::filesystem::status(folder_.path()).permissions(), std::filesystem::perms(0700));
  for (const char* name : {"catalogue.sqlite", "catalogue.sqlite-wal", "identities.sqlite"}) {
    EXPECT_EQ(std::filesystem::status(folder_.path() / name).permissions(),
              std::filesystem::perms(0600))
        << name;
  }
}

TEST(StorageOpenTest, AFolderThatCannotBeMadeIsAnErrorThatNamesIt) {
  const absl::Status status = OpenStorage("/proc/nowhere").status();
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(MessageOf(status), HasSubstr("/proc/nowhere"));
}

TEST_F(StorageTest, IdentitiesAreOpenedBesideAServerThatRuns) {
  const absl::StatusOr<std::unique_ptr<IdentityStore>> beside = OpenIdentities(folder_.path());
  ASSERT_TRUE(beside.ok()) << beside.status();
  const std::string token = *(*beside)->Create(Proof::kToken, {.name = "ops"}, {});
  EXPECT_EQ(storage_->identities->FindToken(token)->name, "ops");
}

class IdentitiesLostTest : public StoreFixture {
 protected:
  IdentitiesLostTest() {
    EXPECT_TRUE(storage_->identities->Create(Proof::kToken, {.name = "ops"}, {}).ok());
    Reopen();
    Close();
  }

  absl::Status Open() const { return OpenStorage(folder_.path()).status(); }

  void ExpectRefused() const {
    for (int attempt = 0; attempt < 2; ++attempt) {
      EXPECT_EQ(Open().code(), absl::StatusCode::kFailedPrecondition);
      EXPECT_THAT(MessageOf(Open()), AllOf(HasSubstr("missing or empty"), HasSubstr("token create"),
                                           HasSubstr(folder_.path().string())));
    }
  }

  const std::filesystem::path identities_ = folder_.path() / "identities.sqlite";
};

TEST_F(IdentitiesLostTest, MissingOnesAreRefusedUntilThereAreNewOnes) {
  std::filesystem::remove(identities_);
  ExpectRefused();
  const auto anew = OpenIdentities(folder_.path());
  ASSERT_TRUE(anew.ok()) << anew.status();
  ASSERT_TRUE((*anew)->Create(Proof::kToken, {.name = "ops"}, {}).ok());
  EXPECT_TRUE(Open().ok());
}

TEST_F(IdentitiesLostTest, AnEmptyFileIsRefused) {
  std::filesystem::resize_file(identities_, 0);
  ExpectRefused();
}

TEST_F(StorageTest, AStoreThatNeverHadIdentitiesNeedsNone) {
  Close();
  std::filesystem::remove(folder_.path() / "identities.sqlite");
  EXPECT_TRUE(OpenStorage(folder_.path()).ok());
}

}  // namespace
}  // namespace dcloc::server
