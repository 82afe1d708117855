#include "server/maps/store/copy_map_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/test_maps.h"

namespace dcloc::server {
namespace {

class CopyMapFileTest : public ::testing::Test {
 protected:
  absl::Status Copy(const std::string& sha256, bool go_on = true) const {
    return CopyMapFile(from_, to_, sha256, [go_on](std::size_t) { return go_on; });
  }

  std::ptrdiff_t FileCount() const {
    return std::distance(std::filesystem::directory_iterator(folder_.path()), {});
  }

  const TemporaryFolder folder_;
  const std::vector<std::byte> bytes_ = SmallMap();
  const std::filesystem::path from_ = folder_.Write("from", bytes_);
  const std::filesystem::path to_ = folder_.path() / "to";
};

TEST_F(CopyMapFileTest, IsWholeOrNotThere) {
  EXPECT_EQ(Copy(std::string(64, '0')).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(Copy(Sha256Of(bytes_), /*go_on=*/false).code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(FileCount(), 1) << "nothing is left of them";
  EXPECT_TRUE(Copy(Sha256Of(bytes_)).ok());
  EXPECT_EQ(std::filesystem::file_size(to_), bytes_.size());
  EXPECT_EQ(Copy(std::string(64, '0')).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(std::filesystem::file_size(to_), bytes_.size()) << "what was there stays";
  EXPECT_EQ(FileCount(), 2);
}

TEST_F(CopyMapFileTest, WhatIsMissingIsNotFound) {
  std::filesystem::remove(from_);
  EXPECT_EQ(Copy(Sha256Of(bytes_)).code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc::server
