#include "server/base/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

class FilesTest : public ::testing::Test {
 protected:
  const TemporaryFolder folder_;
  const std::filesystem::path missing_ = folder_.path() / "no" / "file";
};

TEST_F(FilesTest, ErrorsNameThePathToOperatorsOnly) {
  const std::string path = missing_.string();
  for (const absl::Status& status :
       {OpenOrCreate(missing_).status(), OpenToRead(missing_).status(), SyncFile(missing_),
        MoveFile(missing_, folder_.path() / "x"), CreateFolders("/proc/nowhere"),
        FileError(std::make_error_code(std::errc::io_error), missing_)}) {
    ASSERT_FALSE(status.ok());
    EXPECT_THAT(std::string(status.message()), Not(AnyOf(HasSubstr("dcloc"), HasSubstr("nowhere"))))
        << status;
    EXPECT_THAT(std::string(WithPath(status).message()), HasSubstr("/"));
    EXPECT_EQ(WithPath(status).code(), status.code());
  }
  EXPECT_THAT(std::string(WithPath(OpenToRead(missing_).status()).message()), HasSubstr(path));
  EXPECT_TRUE(WithPath(absl::OkStatus()).ok());
}

TEST_F(FilesTest, WhatIsMissingIsNotFoundAndAFolderIsNoFile) {
  EXPECT_EQ(OpenToRead(missing_).status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(OpenToRead(folder_.path()).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(*FileSize(missing_), 0);
  EXPECT_TRUE(RemoveFile(folder_.path() / "none").ok());
}

}  // namespace
}  // namespace dcloc::server
