#include "server/maps/catalogue/postgres_catalogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/postgres/postgres_error.h"
#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/postgres_cluster.h"

// What servers that share one database see of each other, and what becomes of it when it fails.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Clock = std::chrono::steady_clock;

constexpr char kEndLeases[] =
    "UPDATE dcloc.holder SET lease_end = clock_timestamp() - interval '1 s' WHERE name = 'b:1'";
/// As if the database had been running for long.
constexpr char kForgetStart[] =
    "CREATE OR REPLACE VIEW dcloc.live_holder AS"
    " SELECT name FROM dcloc.holder WHERE lease_end > clock_timestamp()";

std::string HashOfAll(char digit) { return std::string(64, digit); }

template <typename Predicate>
bool Within(std::chrono::milliseconds time, Predicate done) {
  const Clock::time_point end = Clock::now() + time;
  while (!done()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

constexpr std::chrono::seconds kSoon(1);
constexpr std::chrono::seconds kRecovery(5);

/// Two servers' catalogues on one database, with versions 1 and 2 of a map, of which 1 is active.
class PostgresCatalogueTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    address_ = PostgresCluster::Get().NewDatabase();
    a_ = Open();
    b_ = Open();
    for (const char digit : {'a', 'b'}) {
      ASSERT_TRUE(a_->AddVersion("town", HashOfAll(digit), {}, {}).ok());
    }
    ASSERT_TRUE(a_->Activate("town", 1).ok());
    Run(kForgetStart);
  }

  std::unique_ptr<Catalogue> Open() const {
    PostgresOptions options{.address = address_};
    options.statement_timeout = std::chrono::milliseconds(1000);
    return *PostgresCatalogue::Open(*PostgresDatabase::Open(options));
  }

  std::vector<std::string> Run(const std::string& sql) const {
    return PostgresCluster::Run(address_, sql);
  }

  std::string address_;
  std::unique_ptr<Catalogue> a_, b_;
};

TEST_F(PostgresCatalogueTest, LabelsThatOneSetsTheOtherSeesWithinASecond) {
  for (int round = 0; round < 10; ++round) {
    const std::int64_t next = round % 2 == 0 ? 2 : 1;
    EXPECT_EQ(b_->GetVersion("town", 0)->version, 3 - next);
    ASSERT_TRUE(a_->Activate("town", next).ok());
    EXPECT_EQ(a_->GetVersion("town", 0)->version, next) << "who sets it sees it at once";
    EXPECT_TRUE(Within(kSoon, [&] { return b_->GetVersion("town", 0)->version == next; }));
  }
  ASSERT_TRUE(a_->SetCanary("town", 2, 0.5).ok());
  EXPECT_TRUE(Within(kSoon, [&] { return b_->GetMap("town")->canary_share == 0.5; }));
}

TEST_F(PostgresCatalogueTest, AVersionThatOneUsesTheOtherDoesNotDelete) {
  Hold hold = *b_->HoldVersion("town", 2, "b:1");
  EXPECT_THAT(MessageOf(a_->DeleteVersion("town", 2)), HasSubstr("in use"));
  EXPECT_THAT(MessageOf(a_->DeleteMap("town")), HasSubstr("version 2"));
  hold = Hold();
  EXPECT_TRUE(Within(kSoon, [&] { return a_->DeleteVersion("town", 2).ok(); }));
}

TEST_F(PostgresCatalogueTest, TheHoldsOfOneThatDiedEndWithItsLease) {
  Run("INSERT INTO dcloc.holder VALUES ('dead:1', clock_timestamp() + interval '2 s');"
      "INSERT INTO dcloc.version_hold VALUES ('dead:1', 'town', 2);"
      "INSERT INTO dcloc.file_hold VALUES (repeat('f', 64), 'dead:1', nextval("
      "'dcloc.file_hold_token'))");
  EXPECT_EQ(a_->DeleteVersion("town", 2).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_FALSE(a_->HoldFile(HashOfAll('f'), "a:1").ok());
  EXPECT_TRUE(Within(kRecovery, [&] { return a_->DeleteVersion("town", 2).ok(); }));
  EXPECT_TRUE(a_->HoldFile(HashOfAll('f'), "a:1").ok());
}

TEST_F(PostgresCatalogueTest, ALeaseIsRenewedAndWhoWasAwayForLongHoldsItAllAgain) {
  const Hold hold = *b_->HoldVersion("town", 2, "b:1");
  Run("DELETE FROM dcloc.holder");  // as if it had been dead for long
  EXPECT_TRUE(Within(kRecovery, [&] {
    return Run("SELECT holder FROM dcloc.version_hold") == std::vector<std::string>{"b:1"};
  }));
  EXPECT_EQ(a_->DeleteVersion("town", 2).code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(PostgresCatalogueTest, AfterAStartOfTheDatabaseNobodyIsTakenForDead) {
  address_ = PostgresCluster::Get().NewDatabase();  // with the view as it is made
  const auto c = Open();
  ASSERT_TRUE(c->AddVersion("town", HashOfAll('a'), {}, {}).ok());
  Run("INSERT INTO dcloc.holder VALUES ('b:1', clock_timestamp() - interval '10 s');"
      "INSERT INTO dcloc.version_hold VALUES ('b:1', 'town', 1)");
  PostgresCluster::Get().Stop();
  PostgresCluster::Get().Start();
  EXPECT_TRUE(
      Within(kRecovery, [&] { return absl::IsFailedPrecondition(c->DeleteVersion("town", 1)); }));
}

TEST_F(PostgresCatalogueTest, WhoLostAFileAddsNoVersionOfIt) {
  const Hold lost = *b_->HoldFile(HashOfAll('f'), "b:1");
  ASSERT_TRUE(b_->AddLooseFile(HashOfAll('f')).ok());
  {
    absl::StatusOr<Hold> taken;
    EXPECT_TRUE(Within(kRecovery, [&] {
      Run(kEndLeases);  // which is renewed now and then
      taken = a_->HoldFile(HashOfAll('f'), "a:1");
      return taken.ok();
    }));
    const auto added = b_->AddVersion("town", HashOfAll('f'), {}, {});
    EXPECT_EQ(added.status().code(), absl::StatusCode::kUnavailable);
    EXPECT_THAT(MessageOf(added.status()), HasSubstr("upload it again"));
  }
  EXPECT_FALSE(*a_->HasFile(HashOfAll('f')));
}

TEST_F(PostgresCatalogueTest, ChangesThatAreCutInTheMiddleAreWholeOrNot) {
  std::atomic<bool> stop = false;
  std::atomic<int> acknowledged = 0;
  std::vector<std::thread> clients;
  for (const auto& catalogue : {a_.get(), b_.get()}) {
    clients.emplace_back([&, catalogue, k = clients.size()] {
      for (int i = 0; !stop; ++i) {
        const std::string sha256 = absl::StrCat(std::string(56, 'c'), k, 1'000'000 + i);
        const CoverageBox box{.map_m = {0, 1, 0, 1}, .degrees = std::nullopt};
        const auto added = catalogue->AddVersion("cut", sha256, {}, {box, box});
        if (!added.ok()) continue;
        ++acknowledged;
        const auto found = catalogue->GetVersion("cut", added->version);
        EXPECT_TRUE(found.ok() || absl::IsUnavailable(found.status())) << found.status();
      }
    });
  }
  // On a busy machine a change takes longer than the time between two cuts: the time grows.
  for (int i = 0; i < 20 || (acknowledged == 0 && i < 60); ++i) {
    PostgresCluster::CutConnections(address_);
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + 10 * i));
  }
  stop = true;
  for (std::thread& client : clients) client.join();
  EXPECT_GT(acknowledged, 0);
  const auto versions = Run("SELECT count(*) FROM dcloc.map_version WHERE map_name = 'cut'");
  EXPECT_GE(std::stoi(versions.at(0)), acknowledged) << "nothing acknowledged is lost";
  EXPECT_THAT(Run("SELECT map_name FROM dcloc.map_version AS v WHERE map_name = 'cut' AND 2 <>"
                  " (SELECT count(*) FROM dcloc.coverage_box AS b WHERE b.map_name = v.map_name"
                  " AND b.version = v.version)"),
              IsEmpty())
      << "no version without its boxes";
}

TEST_F(PostgresCatalogueTest, WhileTheDatabaseIsAwayWhatWasKnownIsUsedAndNothingIsChanged) {
  ASSERT_TRUE(a_->GetMap("town").ok());
  ASSERT_TRUE(a_->GetVersion("town", 0).ok());
  PostgresCluster::Get().Stop();
  EXPECT_EQ(a_->GetMap("town")->active_version, 1);
  EXPECT_EQ(a_->GetVersion("town", 0)->version, 1);
  const absl::StatusOr<Hold> hold = a_->HoldVersion("town", 1, "a:1");
  EXPECT_TRUE(hold.ok()) << hold.status();
  EXPECT_EQ(a_->HoldVersion("town", 2, "a:1").status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(a_->GetVersion("town", 2).status().code(), absl::StatusCode::kUnavailable);
  const absl::Status written = a_->Activate("town", 2);
  EXPECT_EQ(written.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(MessageOf(written), HasSubstr("try again"));
  PostgresCluster::Get().Start();
  EXPECT_TRUE(Within(kRecovery, [&] { return a_->Activate("town", 2).ok(); }));
}

TEST_F(PostgresCatalogueTest, AHoldTakenWhileItIsAwayIsSeenByAllOnceItIsBack) {
  ASSERT_TRUE(b_->GetVersion("town", 2).ok());
  PostgresCluster::Get().Stop();
  absl::StatusOr<Hold> hold = b_->HoldVersion("town", 2, "b:1");
  EXPECT_TRUE(hold.ok()) << hold.status();
  PostgresCluster::Get().Start();
  EXPECT_TRUE(Within(kRecovery, [&] {
    return Run("SELECT holder FROM dcloc.version_hold") == std::vector<std::string>{"b:1"};
  }));
  EXPECT_TRUE(Within(kRecovery, [&] {
    const absl::Status refused = a_->DeleteVersion("town", 2);
    EXPECT_FALSE(refused.ok());
    return absl::IsFailedPrecondition(refused);  // until then a's own connections are away
  }));
  *hold = Hold();
  EXPECT_TRUE(Within(kRecovery, [&] { return a_->DeleteVersion("town", 2).ok(); }));
}

TEST_F(PostgresCatalogueTest, OneThatIsLockedHoldsUpNoReader) {
  PostgresOptions options{.address = address_};
  const auto locker = *PostgresConnection::Open(options);
  ASSERT_TRUE(locker->Query("BEGIN").ok());
  ASSERT_TRUE(locker->Query("LOCK TABLE map, map_version IN EXCLUSIVE MODE").ok());
  const Clock::time_point begin = Clock::now();
  EXPECT_TRUE(a_->GetMap("town").ok());
  EXPECT_TRUE(a_->ListVersions("town", 10, 10).ok());
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(1));
  const absl::Status status = a_->Activate("town", 2);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_FALSE(IsAway(status));
  ASSERT_TRUE(locker->Query("COMMIT").ok());
  EXPECT_TRUE(a_->Activate("town", 2).ok());
}

TEST_F(PostgresCatalogueTest, ACatalogueOfANewerProgramIsRefused) {
  Run("UPDATE dcloc.schema_version SET version = 99 WHERE part = 'catalogue'");
  const auto opened = PostgresCatalogue::Open(*PostgresDatabase::Open({.address = address_}));
  EXPECT_EQ(opened.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(MessageOf(opened.status()), HasSubstr("version 99"));
}

}  // namespace
}  // namespace dcloc::server
