#include "server/base/small_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <string>

#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(SmallFileTest, IsReadWholeOrRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "file";
  std::ofstream(path) << "twelve bytes";
  EXPECT_EQ(*ReadSmallFile(path), "twelve bytes");
  EXPECT_EQ(*ReadSmallFile(path, 12), "twelve bytes");
  const absl::Status large = ReadSmallFile(path, 11).status();
  EXPECT_EQ(large.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(large.message()), AllOf(HasSubstr(path.string()), HasSubstr("11 bytes")));
}

TEST(SmallFileTest, WhatIsNoRegularFileIsRefusedAtOnce) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadSmallFile(folder.path() / "nowhere").status().code(), absl::StatusCode::kNotFound);
  const absl::Status status = ReadSmallFile(folder.path()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no regular file"));
  const std::filesystem::path pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(ReadSmallFile(pipe).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace dcloc::server
