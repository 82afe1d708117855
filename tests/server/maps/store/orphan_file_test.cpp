#include "server/maps/store/orphan_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/map_folder.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

class OrphanFileTest : public ::testing::Test {
 protected:
  OrphanFileTest() {
    const auto path = MapFolder::PathIn(folder_.path() / "maps", sha256_);
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << "a map";
    EXPECT_TRUE(catalogue_->AddLooseFile(sha256_).ok());
  }

  bool IsThere() const { return !files_->List()->empty(); }

  const std::string sha256_ = std::string(64, 'a');
  const TemporaryFolder folder_;
  const std::unique_ptr<Catalogue> catalogue_ =
      *SqliteCatalogue::Open(folder_.path() / "catalogue.sqlite");
  const std::unique_ptr<MapFiles> files_ =
      *MapFolder::Open(folder_.path() / "maps", folder_.path() / "quarantine");
};

TEST_F(OrphanFileTest, OneThatNobodyNeedsIsRemovedAndForgotten) {
  EXPECT_TRUE(RemoveOrphan(*catalogue_, *files_, sha256_, "this:1").value_or(false));
  EXPECT_FALSE(IsThere());
  EXPECT_EQ(*catalogue_->ListLooseFiles(), std::vector<std::string>());
  EXPECT_EQ(files_->QuarantinedCount().value_or(-1), 0);
}

TEST_F(OrphanFileTest, OneThatNobodyAskedToBeRidOfIsSetAside) {
  EXPECT_TRUE(QuarantineOrphan(*catalogue_, *files_, sha256_, "this:1").value_or(false));
  EXPECT_FALSE(IsThere());
  EXPECT_EQ(files_->QuarantinedCount().value_or(-1), 1);
}

TEST_F(OrphanFileTest, OneThatAnotherProcessStoresStays) {
  const absl::StatusOr<Hold> hold = catalogue_->HoldFile(sha256_, "other:1");
  ASSERT_TRUE(hold.ok()) << hold.status();
  const auto removed = RemoveOrphan(*catalogue_, *files_, sha256_, "this:1");
  ASSERT_TRUE(removed.ok()) << removed.status();
  EXPECT_FALSE(*removed);
  EXPECT_TRUE(IsThere());
  EXPECT_EQ(*catalogue_->ListLooseFiles(), std::vector<std::string>{sha256_});
}

TEST_F(OrphanFileTest, OneThatHasAVersionStays) {
  ASSERT_TRUE(catalogue_->AddVersion("town", sha256_, {}, {}).ok());
  EXPECT_FALSE(QuarantineOrphan(*catalogue_, *files_, sha256_, "this:1").value_or(true));
  EXPECT_TRUE(IsThere());
}

}  // namespace
}  // namespace dcloc::server
