#include "server/identity/sqlite_identity_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "server/base/sha256.h"
#include "server/base/sqlite.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class SqliteIdentityStoreTest : public ::testing::Test {
 protected:
  std::unique_ptr<IdentityStore> Open() const {
    absl::StatusOr<std::unique_ptr<IdentityStore>> store = SqliteIdentityStore::Open(path_);
    EXPECT_TRUE(store.ok()) << store.status();
    return *std::move(store);
  }

  static SystemTime In(std::chrono::seconds duration) {
    return std::chrono::system_clock::now() + duration;
  }

  /// Gives an identity a role that this program does not know.
  void SpoilRole(std::int64_t id) const {
    absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path_);
    ASSERT_TRUE(database.ok()) << database.status();
    SqliteStatement update(*database, "UPDATE identity SET role = 'root' WHERE id = ?");
    ASSERT_TRUE(update.Bind(id).Run().ok());
  }

  TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "identities.sqlite";
  std::unique_ptr<IdentityStore> store_ = Open();
};

TEST_F(SqliteIdentityStoreTest, ATokenIsItsPrincipal) {
  EXPECT_FALSE(*store_->HasAny());
  const Principal principal{.name = "car-1", .tenant = "acme", .role = Role::kVehicle};
  const std::string token = *store_->Create(Proof::kToken, principal, In(std::chrono::hours(1)));
  EXPECT_THAT(token, ::testing::StartsWith("dcloc_"));
  EXPECT_GE(token.size(), 40U);
  EXPECT_EQ(*store_->FindToken(token), principal);
  EXPECT_TRUE(*store_->HasAny());
  const absl::Status status = store_->FindToken(token + "x").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("not known"), Not(HasSubstr(token))));
  EXPECT_NE(*store_->Create(Proof::kToken, principal, {}), token);
}

TEST_F(SqliteIdentityStoreTest, OnlyTheHashIsAtRest) {
  const std::string token = *store_->Create(Proof::kToken, {.name = "ops"}, {});
  store_.reset();  // writes everything into the file
  std::ifstream file(path_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  Sha256 hash;
  hash.Update(std::as_bytes(std::span(token)));
  EXPECT_THAT(bytes, AllOf(Not(HasSubstr(token)), HasSubstr(hash.Finish())));
}

TEST_F(SqliteIdentityStoreTest, ExpiredAndRevokedTokensSaySo) {
  const std::string expired =
      *store_->Create(Proof::kToken, {.name = "a"}, In(-std::chrono::seconds(1)));
  EXPECT_THAT(MessageOf(store_->FindToken(expired).status()), HasSubstr("expired"));
  const std::string token = *store_->Create(Proof::kToken, {.name = "b"}, {});
  ASSERT_TRUE(store_->FindToken(token).ok());
  ASSERT_TRUE(store_->Revoke(2).ok());
  const absl::Status status = store_->FindToken(token).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(MessageOf(status), HasSubstr("revoked"));
  const SystemTime revoked = *store_->List()->at(1).revoke_time;
  EXPECT_TRUE(store_->Revoke(2).ok());
  EXPECT_EQ(store_->List()->at(1).revoke_time, revoked);
  EXPECT_EQ(store_->Revoke(7).code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(*store_->HasAny()) << "revoking the last one opens nothing";
}

TEST_F(SqliteIdentityStoreTest, AnotherProcessesChangesHoldAtOnce) {
  const std::unique_ptr<IdentityStore> other = Open();
  const std::string token = *other->Create(Proof::kToken, {.name = "a"}, {});
  EXPECT_TRUE(store_->FindToken(token).ok());
  EXPECT_TRUE(*store_->HasAny());
  ASSERT_TRUE(other->Revoke(1).ok());
  EXPECT_FALSE(store_->FindToken(token).ok());
}

TEST_F(SqliteIdentityStoreTest, CertificatesAreFoundByCommonName) {
  const Principal car{.name = "car-1", .role = Role::kVehicle};
  ASSERT_TRUE(store_->Create(Proof::kCertificate, car, {}).ok());
  EXPECT_EQ(*store_->FindCertificate("car-1"), car);
  EXPECT_EQ(store_->FindCertificate("car-2").status().code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(store_->Create(Proof::kCertificate, car, {}).status().code(),
            absl::StatusCode::kAlreadyExists);
  ASSERT_TRUE(store_->Revoke(1).ok());
  EXPECT_FALSE(store_->FindCertificate("car-1").ok());
  EXPECT_TRUE(store_->Create(Proof::kCertificate, car, {}).ok()) << "after the first was revoked";
  EXPECT_TRUE(store_->FindCertificate("car-1").ok());
}

TEST_F(SqliteIdentityStoreTest, BadNamesAreRefusedByName) {
  const auto error_of = [&](const Principal& principal) {
    const absl::Status status = store_->Create(Proof::kToken, principal, {}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return MessageOf(status);
  };
  EXPECT_THAT(error_of({.name = ""}), HasSubstr("name"));
  EXPECT_THAT(error_of({.name = "a b"}), HasSubstr("name is \"a b\""));
  EXPECT_THAT(error_of({.name = "a", .tenant = "Ac/me"}), HasSubstr("tenant"));
  EXPECT_FALSE(*store_->HasAny());
}

TEST_F(SqliteIdentityStoreTest, AnUnknownRoleIsAnErrorThatNamesWhoseItIs) {
  const std::string token = *store_->Create(Proof::kToken, {.name = "ops"}, {});
  ASSERT_TRUE(store_->Create(Proof::kCertificate, {.name = "car-1"}, {}).ok());
  SpoilRole(1);
  const absl::Status status = store_->FindToken(token).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(MessageOf(status),
              AllOf(HasSubstr("identity 1"), HasSubstr("\"ops\""), HasSubstr("\"root\"")));
  EXPECT_EQ(store_->List().status(), status);
  EXPECT_TRUE(store_->FindCertificate("car-1").ok()) << "the others go on";
  EXPECT_TRUE(store_->Revoke(1).ok()) << "and it can be ended";
}

}  // namespace
}  // namespace dcloc::server
