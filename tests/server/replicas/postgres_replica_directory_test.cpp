#include "server/replicas/postgres_replica_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/postgres/postgres_database.h"
#include "tests/server/fixtures/eventually.h"
#include "tests/server/fixtures/postgres_cluster.h"

namespace dcloc::server {
namespace {

using ::testing::ElementsAre;

class PostgresReplicaDirectoryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    database_ = PostgresCluster::Get().NewDatabase();
  }

  /// Each has a connection and an owner's name of its own, as servers have.
  std::unique_ptr<PostgresReplicaDirectory> Open() const {
    return *PostgresReplicaDirectory::Open(*PostgresDatabase::Open({.address = database_}));
  }

  std::vector<std::string> Read(const std::string& column) const {
    return PostgresCluster::Run(
        database_, absl::StrCat("SELECT ", column, " FROM dcloc.replica ORDER BY address"));
  }

  void Run(const std::string& sql) const { PostgresCluster::Run(database_, sql); }

  std::string database_;
};

TEST_F(PostgresReplicaDirectoryTest, ServersSeeEachOtherUntilOneGoes) {
  const auto a = Open();
  auto b = Open();
  a->Announce("a:1");
  b->Announce("b:1");
  EXPECT_TRUE(Eventually([&] { return a->Others() == std::vector<std::string>{"b:1"}; }));
  EXPECT_TRUE(Eventually([&] { return b->Others() == std::vector<std::string>{"a:1"}; }));
  b.reset();
  EXPECT_TRUE(Eventually([&] { return a->Others().empty(); }));
}

TEST_F(PostgresReplicaDirectoryTest, OfTwoWithOneNameTheFirstKeepsItsRow) {
  auto first = Open();
  first->Announce("same:1");
  ASSERT_TRUE(Eventually([&] { return Read("address").size() == 1; }));
  const std::vector<std::string> owner = Read("owner");
  auto second = Open();
  second->Announce("same:1");
  const auto witness = Open();
  witness->Announce("witness:1");
  ASSERT_TRUE(Eventually([&] { return witness->Others().size() == 1; }));
  EXPECT_EQ(Read("owner").front(), owner.front());
  second.reset();
  EXPECT_EQ(Read("owner").front(), owner.front()) << "it takes away its own row alone";
  second = Open();
  second->Announce("same:1");
  first.reset();
  EXPECT_TRUE(Eventually([&] {
    const std::vector<std::string> owners = Read("owner");
    return owners.size() == 2 && owners.front() != owner.front();
  })) << "and gets the row once the first has gone";
}

TEST_F(PostgresReplicaDirectoryTest, AServerThatKnowsNoOwnersIsKnownStill) {
  Open();
  Run("UPDATE dcloc.schema_version SET version = 1 WHERE part = 'replicas';"
      "ALTER TABLE dcloc.replica DROP COLUMN owner;"
      "INSERT INTO dcloc.replica VALUES ('old:1', clock_timestamp() + interval '4 s')");
  const auto directory = Open();
  directory->Announce("new:1");
  EXPECT_TRUE(Eventually([&] { return directory->Others().size() == 1; }));
  EXPECT_THAT(directory->Others(), ElementsAre("old:1"));
  EXPECT_THAT(Read("owner = ''"), ElementsAre("f", "t"));
}

}  // namespace
}  // namespace dcloc::server
