#include "server/base/sqlite_copy.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "server/base/sqlite.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

class SqliteCopyTest : public ::testing::Test {
 protected:
  SqliteCopyTest() {
    EXPECT_TRUE(writer_
                    .Run("PRAGMA journal_mode = WAL; CREATE TABLE item (name TEXT);"
                         "INSERT INTO item VALUES ('one')")
                    .ok());
  }

  static std::int64_t CountIn(const std::filesystem::path& path) {
    absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path, SqliteAccess::kRead);
    if (!database.ok()) return -1;
    SqliteStatement query(*database, "SELECT COUNT(*) FROM item");
    return query.Step().ok() ? query.NextInteger() : -1;
  }

  const TemporaryFolder folder_;
  const std::filesystem::path from_ = folder_.path() / "from";
  const std::filesystem::path to_ = folder_.path() / "to";
  SqliteDatabase writer_ = *SqliteDatabase::Open(from_);
};

TEST_F(SqliteCopyTest, CopiesWhatIsCommittedWhileAnotherOneWrites) {
  ASSERT_TRUE(writer_.Run("BEGIN IMMEDIATE; INSERT INTO item VALUES ('two')").ok());
  const absl::Status status = CopyDatabase(from_, to_);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(CountIn(to_), 1);
  ASSERT_TRUE(writer_.Run("COMMIT").ok());
  ASSERT_TRUE(CopyDatabase(from_, to_).ok());
  EXPECT_EQ(CountIn(to_), 2) << "the older copy was replaced";
  EXPECT_FALSE(std::filesystem::exists(to_.string() + "-wal")) << "one file alone";
}

TEST_F(SqliteCopyTest, WhatCannotBeCopiedLeavesTheOlderCopy) {
  ASSERT_TRUE(CopyDatabase(from_, to_).ok());
  const std::filesystem::path broken = folder_.path() / "broken";
  std::ofstream(broken) << std::string(8192, 'x');
  EXPECT_EQ(CopyDatabase(broken, to_).code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(CopyDatabase(folder_.path() / "none", to_).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(CountIn(to_), 1);
  EXPECT_FALSE(std::filesystem::exists(to_.string() + ".partial"));
}

TEST_F(SqliteCopyTest, ACheckFindsAFault) {
  ASSERT_TRUE(CopyDatabase(from_, to_).ok());
  EXPECT_TRUE(CheckDatabase(to_).ok());
  std::fstream file(to_, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(4096);
  file << std::string(4096, 'x');
  file.close();
  EXPECT_EQ(CheckDatabase(to_).code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dcloc::server
