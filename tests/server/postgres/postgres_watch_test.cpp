#include "server/postgres/postgres_watch.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "server/postgres/postgres_database.h"
#include "server/postgres/postgres_error.h"
#include "server/postgres/query_cache.h"
#include "tests/server/fixtures/postgres_cluster.h"

namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

class PostgresWatchTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    address_ = PostgresCluster::Get().NewDatabase();
    auto database = PostgresDatabase::Open({.address = address_});
    ASSERT_TRUE(database.ok()) << database.status();
    database_ = *std::move(database);
    Run("CREATE TABLE dcloc.thing (n bigint); INSERT INTO dcloc.thing VALUES (1);"
        "CREATE CONSTRAINT TRIGGER thing_change AFTER UPDATE ON dcloc.thing DEFERRABLE INITIALLY"
        " DEFERRED FOR EACH ROW EXECUTE FUNCTION dcloc.note_change('catalogue')");
  }

  void Run(const std::string& sql) const { PostgresCluster::Run(address_, sql); }

  ChangeState State() const { return database_->watch->state(ChangeTopic::kCatalogue); }

  template <typename Predicate>
  static milliseconds TimeUntil(Predicate done) {
    const Clock::time_point begin = Clock::now();
    while (!done() && Clock::now() - begin < std::chrono::seconds(30)) {
      std::this_thread::sleep_for(milliseconds(1));
    }
    return std::chrono::duration_cast<milliseconds>(Clock::now() - begin);
  }

  absl::StatusOr<std::int64_t> AskThing() const {
    return database_->pool.WithConnection(
        [](PostgresConnection& connection) -> absl::StatusOr<std::int64_t> {
          absl::StatusOr<PostgresRows> rows = connection.Query("SELECT n FROM thing");
          if (!rows.ok()) return rows.status();
          rows->Next();
          return rows->NextInteger();
        });
  }

  std::string address_;
  std::shared_ptr<PostgresDatabase> database_;
};

TEST_F(PostgresWatchTest, AChangeIsSeenAndAChangeThatIsTakenBackIsNot) {
  const std::int64_t before = State().number;
  Run("BEGIN; UPDATE dcloc.thing SET n = 2; ROLLBACK");
  std::this_thread::sleep_for(2 * PostgresWatch::kInterval);
  EXPECT_EQ(State().number, before);
  Run("UPDATE dcloc.thing SET n = 2");
  EXPECT_LT(TimeUntil([&] { return State().number == before + 1; }), std::chrono::seconds(1));
  EXPECT_TRUE(State().fresh);
}

TEST_F(PostgresWatchTest, AChangeWhileTheConnectionIsCutIsSeenAfterwards) {
  const std::int64_t before = State().number;
  PostgresCluster::CutConnections(address_);
  Run("UPDATE dcloc.thing SET n = 2");
  PostgresCluster::CutConnections(address_);
  EXPECT_LT(TimeUntil([&] { return State().number == before + 1; }), std::chrono::seconds(5));
}

TEST_F(PostgresWatchTest, AnAnswerIsAskedOnceUntilSomethingChanges) {
  QueryCache<std::string, std::int64_t> memory(*database_->watch, ChangeTopic::kCatalogue, {});
  int asked = 0;
  const auto get = [&] {
    return memory.Get("n", [&] {
      ++asked;
      return AskThing();
    });
  };
  ASSERT_LT(TimeUntil([&] { return *get() == 1 && asked > 0 && State().fresh; }),
            std::chrono::seconds(1));
  asked = 0;
  // Within one look of the watch nothing is asked twice.
  for (int i = 0; i < 100; ++i) EXPECT_EQ(*get(), 1);
  EXPECT_LE(asked, 1);
  Run("UPDATE dcloc.thing SET n = 2");
  EXPECT_LT(TimeUntil([&] { return *get() == 2; }), std::chrono::seconds(1));
  memory.Forget();
  asked = 0;
  EXPECT_EQ(*get(), 2);
  EXPECT_EQ(asked, 1) << "an own change is asked for at once";
}

TEST_F(PostgresWatchTest, WhileItIsAwayWhatWasKnownHoldsForAsLongAsIsSaid) {
  QueryCache<std::string, std::int64_t> for_good(*database_->watch, ChangeTopic::kCatalogue, {});
  QueryCache<std::string, std::int64_t> briefly(*database_->watch, ChangeTopic::kCatalogue,
                                                {.max_away = std::chrono::seconds(2)});
  const auto ask = [&] { return AskThing(); };
  ASSERT_EQ(*for_good.Get("n", ask), 1);
  ASSERT_EQ(*briefly.Get("n", ask), 1);
  PostgresCluster::Get().Stop();
  EXPECT_LT(TimeUntil([&] { return database_->pool.away(); }), std::chrono::seconds(2));
  EXPECT_EQ(*briefly.Get("n", ask), 1);
  EXPECT_TRUE(IsAway(briefly.Get("m", ask).status())) << "that was never known";
  std::this_thread::sleep_for(std::chrono::seconds(3));
  EXPECT_EQ(*for_good.Get("n", ask), 1);
  EXPECT_TRUE(IsAway(briefly.Get("n", ask).status()));
  PostgresCluster::Get().Start();
  EXPECT_LT(TimeUntil([&] { return briefly.Get("n", ask).ok(); }), std::chrono::seconds(5));
  EXPECT_LT(TimeUntil([&] { return State().fresh; }), std::chrono::seconds(5));
}

}  // namespace
}  // namespace dcloc::server
