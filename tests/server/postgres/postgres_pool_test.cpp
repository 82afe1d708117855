#include "server/postgres/postgres_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "server/postgres/postgres_error.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/postgres_cluster.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

absl::Status Ask(PostgresPool& pool) {
  return pool.WithConnection(
      [](PostgresConnection& connection) { return connection.Query("SELECT 1").status(); });
}

class PostgresPoolTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    options_.address = PostgresCluster::Get().NewDatabase();
    PostgresCluster::Run(options_.address, "CREATE TABLE number (n bigint PRIMARY KEY)");
  }

  static absl::Status Insert(PostgresConnection& connection, std::int64_t number) {
    return connection.Query("INSERT INTO number VALUES ($1)", PostgresValues().Bind(number))
        .status();
  }

  std::string Count() const {
    return PostgresCluster::Run(options_.address, "SELECT count(*) FROM number").at(0);
  }

  PostgresOptions options_{.statement_timeout = std::chrono::milliseconds(500)};
};

TEST_F(PostgresPoolTest, ALostConnectionIsNoLostDatabase) {
  PostgresPool pool(options_);
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(Ask(pool).ok());
    PostgresCluster::CutConnections(options_.address);
  }
  EXPECT_FALSE(pool.away());
}

TEST_F(PostgresPoolTest, ATransactionThatIsCutHasNoEffectAndSaysSo) {
  PostgresPool pool(options_);
  const absl::Status status = pool.InTransaction([&](PostgresConnection& connection) {
    EXPECT_TRUE(Insert(connection, 1).ok());
    PostgresCluster::CutConnections(options_.address);
    return Insert(connection, 2);
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(Count(), "0");
  EXPECT_TRUE(pool.InTransaction([](auto& connection) { return Insert(connection, 3); }).ok());
  EXPECT_EQ(Count(), "1");
}

TEST_F(PostgresPoolTest, WhoIsCutWhileCommittingIsToldThatItIsNotKnown) {
  PostgresPool pool(options_);
  const absl::Status status = pool.InTransaction([&](PostgresConnection& connection) {
    absl::Status inserted = Insert(connection, 1);
    PostgresCluster::CutConnections(options_.address);
    return inserted;
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kInternal);
  EXPECT_THAT(MessageOf(status), HasSubstr("while a change was committed"));
}

TEST_F(PostgresPoolTest, AFailedChangeLeavesNothingOfItsTransaction) {
  PostgresPool pool(options_);
  const absl::Status status = pool.InTransaction([](PostgresConnection& connection) {
    EXPECT_TRUE(Insert(connection, 1).ok());
    return Insert(connection, 1);
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kAlreadyExists);
  EXPECT_EQ(Count(), "0");
  EXPECT_TRUE(pool.InTransaction([](auto& connection) { return Insert(connection, 1); }).ok());
}

TEST_F(PostgresPoolTest, AStatementOfANeverEndingKindEnds) {
  PostgresPool pool(options_);
  const Clock::time_point begin = Clock::now();
  const absl::Status status = pool.WithConnection([](PostgresConnection& connection) {
    return connection.Query("SELECT pg_sleep(60)").status();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(10));
  EXPECT_FALSE(pool.away()) << "it is busy, not away";
}

TEST_F(PostgresPoolTest, ConnectionsAreBoundedAndWhoWaitsTooLongIsToldSo) {
  options_.max_connection_count = 2;
  PostgresPool pool(options_);
  EXPECT_TRUE(pool.WithConnection([&](PostgresConnection&) {
                    return pool.WithConnection([&](PostgresConnection&) {
                      const absl::Status third = Ask(pool);
                      EXPECT_EQ(third.code(), absl::StatusCode::kUnavailable);
                      EXPECT_THAT(MessageOf(third), HasSubstr("all 2 connections"));
                      return absl::OkStatus();
                    });
                  })
                  .ok());
  EXPECT_TRUE(Ask(pool).ok());
}

TEST_F(PostgresPoolTest, WhileItIsAwayNobodyWaitsAndAfterwardsItIsBack) {
  PostgresPool pool(options_);
  ASSERT_TRUE(Ask(pool).ok());
  PostgresCluster::Get().Stop();
  EXPECT_TRUE(IsAway(Ask(pool)));
  EXPECT_TRUE(pool.away());
  const Clock::time_point begin = Clock::now();
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(IsAway(Ask(pool)));
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
  PostgresCluster::Get().Start();
  std::this_thread::sleep_for(PostgresPool::kRetryInterval);
  EXPECT_TRUE(Ask(pool).ok());
  EXPECT_FALSE(pool.away());
}

TEST_F(PostgresPoolTest, AWrongAddressIsAnErrorThatDoesNotSayWhereToClients) {
  PostgresPool pool({.address = "postgresql://dcloc@/none?host=/nowhere"});
  const absl::Status status = Ask(pool);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(MessageOf(status), kDatabaseIsAway);
}

TEST_F(PostgresPoolTest, AWholeTableMayTakeLongerThanOtherStatements) {
  options_.statement_timeout = std::chrono::milliseconds(100);
  const auto connection = *PostgresConnection::Open(options_);
  EXPECT_TRUE(connection->QueryWhole("SELECT pg_sleep(0.4)").ok());
  EXPECT_TRUE(absl::IsUnavailable(connection->Query("SELECT pg_sleep(5)").status()))
      << "which still have their bound";
}

}  // namespace
}  // namespace dcloc::server
