#include "client/datasets/files/paths_below.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/core/map/temporary_folder.h"

namespace dcloc {
namespace {

namespace fs = std::filesystem;

bool IsDrive(const fs::path& path) { return path.extension() == ".drive"; }

TEST(PathsBelowTest, FindsFilesAndFoldersInOrderAndLooksIntoNoneOfThem) {
  const TemporaryFolder folder;
  const fs::path& root = folder.path();
  fs::create_directories(root / "b" / "folder.drive" / "inner.drive");
  std::ofstream(root / "b" / "a.drive") << "x";
  std::ofstream(root / "a.drive") << "x";
  std::ofstream(root / "b" / "other") << "x";
  EXPECT_THAT(PathsBelow(root, IsDrive),
              ::testing::ElementsAre("a.drive", "b/a.drive", "b/folder.drive"));
}

TEST(PathsBelowTest, LooksFourLevelsDeep) {
  const TemporaryFolder folder;
  const fs::path& root = folder.path();
  fs::create_directories(root / "1" / "2" / "3" / "4.drive");
  fs::create_directories(root / "1" / "2" / "3" / "4" / "5.drive");
  EXPECT_THAT(PathsBelow(root, IsDrive), ::testing::ElementsAre("1/2/3/4.drive"));
}

TEST(PathsBelowTest, AFolderThatIsNotThereHasNone) {
  EXPECT_TRUE(PathsBelow("/nowhere/at/all", IsDrive).empty());
}

}  // namespace
}  // namespace dcloc
