#include "server/identity/sqlite_identity_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "server/identity/token.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(SqliteIdentityStoreTest, OnlyTheHashIsAtRest) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "identities.sqlite";
  std::string token;
  {
    const auto store = *SqliteIdentityStore::Open(path);
    token = *store->Create(Proof::kToken, {.name = "ops"}, {});
  }
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(bytes, AllOf(Not(HasSubstr(token)), HasSubstr(HashOfToken(token))));
}

}  // namespace
}  // namespace dcloc::server
