#include "server/app/storage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {
namespace {

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

}  // namespace
}  // namespace dcloc::server
