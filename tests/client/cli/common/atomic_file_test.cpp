#include "client/cli/common/atomic_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <span>
#include <string>

#include "client/cli/common/input_file.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc::cli {
namespace {

std::span<const std::byte> BytesOf(const std::string& text) {
  return std::as_bytes(std::span(text));
}

TEST(AtomicFileTest, AFileIsReplacedWholeAndLeavesNothingBeside) {
  const TempFolder folder;
  const auto path = folder.Write("result.json", "the old one, which is longer");
  ASSERT_TRUE(WriteFileAtomically(path, BytesOf("new")).ok());
  EXPECT_EQ(ReadInputFile(path).value_or(""), "new");
  EXPECT_EQ(WriteFileAtomically(folder.path() / "none" / "x", BytesOf("new")).code(),
            absl::StatusCode::kNotFound);
  // A folder cannot be replaced; the temporary file goes again.
  std::filesystem::create_directory(folder.path() / "folder");
  EXPECT_FALSE(WriteFileAtomically(folder.path() / "folder", BytesOf("new")).ok());
  const std::filesystem::directory_iterator entries(folder.path());
  EXPECT_EQ(std::distance(begin(entries), end(entries)), 2);
}

TEST(InputFileTest, AFolderAndAMissingFileAreNamed) {
  const TempFolder folder;
  EXPECT_EQ(ReadInputFile(folder.path()).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadInputFile(folder.path() / "x").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc::cli
