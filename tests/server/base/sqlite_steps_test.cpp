#include "server/base/sqlite_steps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

constexpr const char* kTwo[] = {"CREATE TABLE a (x INTEGER);", "ALTER TABLE a ADD COLUMN y TEXT;"};

TEST(SqliteStepsTest, EachStepIsTakenOnce) {
  const TemporaryFolder folder;
  {
    SqliteDatabase database = *SqliteDatabase::Open(folder.path() / "d.sqlite");
    EXPECT_TRUE(TakeSteps(database, "jobs", std::span(kTwo).first(1)).ok());
    EXPECT_FALSE(database.Run("INSERT INTO a VALUES (1, 'z')").ok());
  }
  SqliteDatabase database = *SqliteDatabase::Open(folder.path() / "d.sqlite");
  EXPECT_TRUE(TakeSteps(database, "jobs", kTwo).ok());
  EXPECT_TRUE(TakeSteps(database, "jobs", kTwo).ok()) << "nothing is left to do";
  EXPECT_TRUE(database.Run("INSERT INTO a VALUES (1, 'z')").ok());
}

TEST(SqliteStepsTest, ANewerProgramsTablesAreLeftAlone) {
  const TemporaryFolder folder;
  SqliteDatabase database = *SqliteDatabase::Open(folder.path() / "d.sqlite");
  ASSERT_TRUE(TakeSteps(database, "jobs", kTwo).ok());
  const absl::Status status = TakeSteps(database, "jobs", std::span(kTwo).first(1));
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), HasSubstr("jobs: its tables are of step 2"));
}

TEST(SqliteStepsTest, AStepThatFailsChangesNothing) {
  const TemporaryFolder folder;
  SqliteDatabase database = *SqliteDatabase::Open(folder.path() / "d.sqlite");
  constexpr const char* kBad[] = {"CREATE TABLE a (x INTEGER);", "CREATE TABLE a (x INTEGER);"};
  EXPECT_FALSE(TakeSteps(database, "jobs", kBad).ok());
  EXPECT_TRUE(TakeSteps(database, "jobs", kTwo).ok());
}

}  // namespace
}  // namespace dcloc::server
