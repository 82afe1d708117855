#include "server/maps/store/store_check.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

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

  int RemovedCount() const {
    const absl::StatusOr<StoreReport> report =
        CheckStore(*catalogue_, *files_, *incoming_,
                   std::chrono::system_clock::now() - std::chrono::hours(1), "this:1");
    EXPECT_TRUE(report.ok()) << report.status();
    return report->removed_map_file_count;
  }

  const std::string sha256_ = std::string(64, 'a');
  TemporaryFolder folder_;
  const std::unique_ptr<Catalogue> catalogue_ =
      *SqliteCatalogue::Open(folder_.path() / "catalogue.sqlite");
  const std::unique_ptr<MapFiles> files_ = *MapFolder::Open(folder_.path() / "maps");
  const std::unique_ptr<IncomingFiles> incoming_ =
      *IncomingFiles::Open(folder_.path() / "incoming");
};

TEST_F(StoreCheckTest, WhatACrashLeftIsRemovedAndWhatHasAVersionIsNot) {
  WriteMapFile(sha256_);
  WriteMapFile(std::string(64, 'b'));
  ASSERT_TRUE(catalogue_->AddVersion("town", sha256_, {}, {}).ok());
  EXPECT_EQ(RemovedCount(), 1);
  EXPECT_EQ(*files_->List(), std::vector<std::string>{sha256_});
}

TEST_F(StoreCheckTest, AFileThatAnotherProcessIsStoringIsLeftAlone) {
  absl::StatusOr<Hold> other = catalogue_->HoldFile(sha256_, "other:1");
  ASSERT_TRUE(other.ok()) << other.status();
  WriteMapFile(sha256_);
  EXPECT_EQ(RemovedCount(), 0);
  EXPECT_EQ(files_->List()->size(), 1U);
  *other = Hold();  // it has died before it could add its version
  EXPECT_EQ(RemovedCount(), 1);
  EXPECT_TRUE(files_->List()->empty());
}

}  // namespace
}  // namespace dcloc::server
