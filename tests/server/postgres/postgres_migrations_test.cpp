#include "server/postgres/postgres_migrations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/postgres_cluster.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kSteps[] = {
    "CREATE TABLE dcloc.thing (a bigint); SELECT pg_sleep(0.2); INSERT INTO dcloc.thing VALUES (1)",
    "ALTER TABLE dcloc.thing ADD COLUMN b bigint DEFAULT 2",
    "INSERT INTO dcloc.nothing VALUES (1)"};

class PostgresMigrationsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    address_ = PostgresCluster::Get().NewDatabase();
  }

  absl::Status MigrateBy(std::size_t step_count) const {
    const auto connection = PostgresConnection::Open({.address = address_});
    if (!connection.ok()) return connection.status();
    return Migrate(**connection, {.part = "thing", .steps = std::span(kSteps).first(step_count)});
  }

  std::vector<std::string> Run(const char* sql) const {
    return PostgresCluster::Run(address_, sql);
  }

  std::string address_;
};

TEST_F(PostgresMigrationsTest, StepsAreTakenOnceAndForwards) {
  ASSERT_TRUE(MigrateBy(1).ok());
  ASSERT_TRUE(MigrateBy(1).ok());
  ASSERT_TRUE(MigrateBy(2).ok());
  EXPECT_THAT(Run("SELECT a + b FROM dcloc.thing"), ElementsAre("3"));
}

TEST_F(PostgresMigrationsTest, ThoseOfANewerProgramAreRefused) {
  ASSERT_TRUE(MigrateBy(2).ok());
  const absl::Status status = MigrateBy(1);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("version 2"), HasSubstr("knows 1")));
}

TEST_F(PostgresMigrationsTest, AStepThatFailsLeavesNothing) {
  ASSERT_TRUE(MigrateBy(1).ok());
  EXPECT_THAT(MessageOf(MigrateBy(3)), HasSubstr("step 3 of thing"));
  EXPECT_THAT(Run("SELECT version FROM dcloc.schema_version"), ElementsAre("1"));
  ASSERT_TRUE(MigrateBy(2).ok());
}

TEST_F(PostgresMigrationsTest, OfManyProgramsThatStartAtOnceOneDoesIt) {
  std::vector<std::thread> programs;
  for (int i = 0; i < 5; ++i) {
    programs.emplace_back([&] {
      const absl::Status status = MigrateBy(2);
      EXPECT_TRUE(status.ok()) << status;
    });
  }
  for (std::thread& program : programs) program.join();
  EXPECT_THAT(Run("SELECT count(*) FROM dcloc.thing"), ElementsAre("1"));
}

}  // namespace
}  // namespace dcloc::server
