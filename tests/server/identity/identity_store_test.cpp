#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/fixtures/message_of.h"
#include "tests/server/fixtures/places.h"

// What each store of identities promises.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class IdentityStoreTest : public ::testing::TestWithParam<IdentityImplementation> {
 protected:
  void SetUp() override {
    if (!GetParam().is_there) GTEST_SKIP() << GetParam().name << " is not installed";
    place_ = GetParam().make_place();
    store_ = place_->Open();
  }

  static SystemTime In(std::chrono::seconds duration) {
    return std::chrono::system_clock::now() + duration;
  }

  /// A change of another process is seen within this time.
  static void Wait() { std::this_thread::sleep_for(std::chrono::seconds(1)); }

  std::unique_ptr<IdentityPlace> place_;
  std::unique_ptr<IdentityStore> store_;
};

TEST_P(IdentityStoreTest, ATokenIsItsPrincipal) {
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

TEST_P(IdentityStoreTest, ExpiredAndRevokedTokensSaySo) {
  const std::string expired =
      *store_->Create(Proof::kToken, {.name = "a"}, In(-std::chrono::seconds(1)));
  EXPECT_THAT(MessageOf(store_->FindToken(expired).status()), HasSubstr("expired"));
  const std::string token = *store_->Create(Proof::kToken, {.name = "b"}, {});
  ASSERT_TRUE(store_->FindToken(token).ok());
  ASSERT_TRUE(store_->Revoke(2).ok());
  const absl::Status status = store_->FindToken(token).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(MessageOf(status), HasSubstr("revoked"));
  const SystemTime revoked = *store_->List(0, 10)->at(1).revoke_time;
  EXPECT_TRUE(store_->Revoke(2).ok());
  EXPECT_EQ(store_->List(0, 10)->at(1).revoke_time, revoked);
  EXPECT_EQ(store_->Revoke(7).code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(*store_->HasAny()) << "revoking the last one opens nothing";
}

TEST_P(IdentityStoreTest, AnotherProcessesChangesHoldWithinASecond) {
  EXPECT_FALSE(*store_->HasAny());
  const std::unique_ptr<IdentityStore> other = place_->Open();
  const std::string token = *other->Create(Proof::kToken, {.name = "a"}, {});
  EXPECT_TRUE(store_->FindToken(token).ok()) << "what is not known is asked for";
  Wait();
  EXPECT_TRUE(*store_->HasAny());
  ASSERT_TRUE(store_->FindToken(token).ok());
  ASSERT_TRUE(other->Revoke(1).ok());
  Wait();
  EXPECT_FALSE(store_->FindToken(token).ok());
}

TEST_P(IdentityStoreTest, TextsThatNoNameCanHaveAreNotKnown) {
  ASSERT_TRUE(store_->Create(Proof::kCertificate, {.name = "car-1"}, {}).ok());
  for (const std::string& name : {std::string("car-1\0x", 7), std::string("\xff\xfe"),
                                  std::string(5000, 'a'), std::string("' OR 'a' = 'a")}) {
    EXPECT_EQ(store_->FindCertificate(name).status().code(), absl::StatusCode::kUnauthenticated);
    EXPECT_EQ(store_->FindToken(name).status().code(), absl::StatusCode::kUnauthenticated);
  }
}

TEST_P(IdentityStoreTest, CertificatesAreFoundByCommonName) {
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

TEST_P(IdentityStoreTest, BadNamesAreRefusedByName) {
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

TEST_P(IdentityStoreTest, PagesHaveEachIdentityOnceInOrder) {
  constexpr int kIdentities = 7;
  for (int i = 0; i < kIdentities; ++i) {
    ASSERT_TRUE(store_->Create(Proof::kToken, {.name = "car-" + std::to_string(i)}, {}).ok());
  }
  std::vector<std::string> names;
  std::int64_t last = 0;
  while (true) {
    const auto page = store_->List(last, 3);
    ASSERT_TRUE(page.ok()) << page.status();
    ASSERT_LE(page->size(), 3U);
    if (page->empty()) break;
    for (const IdentityRecord& record : *page) {
      EXPECT_GT(record.id, last);
      last = record.id;
      names.push_back(record.principal.name);
    }
  }
  ASSERT_EQ(names.size(), std::size_t{kIdentities});
  for (int i = 0; i < kIdentities; ++i) EXPECT_EQ(names[i], "car-" + std::to_string(i));
}

TEST_P(IdentityStoreTest, AnUnknownRoleIsAnErrorThatNamesWhoseItIs) {
  const std::string token = *store_->Create(Proof::kToken, {.name = "ops"}, {});
  ASSERT_TRUE(store_->Create(Proof::kCertificate, {.name = "car-1"}, {}).ok());
  place_->SpoilRole(1);
  const absl::Status status = store_->FindToken(token).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(MessageOf(status),
              AllOf(HasSubstr("identity 1"), HasSubstr("\"ops\""), HasSubstr("\"root\"")));
  EXPECT_EQ(store_->List(0, 10).status(), status);
  EXPECT_EQ(store_->List(1, 10)->size(), 1U) << "pages without it can be read";
  EXPECT_TRUE(store_->FindCertificate("car-1").ok()) << "the others go on";
  EXPECT_TRUE(store_->Revoke(1).ok()) << "and it can be ended";
}

INSTANTIATE_TEST_SUITE_P(Identities, IdentityStoreTest,
                         ::testing::ValuesIn(IdentityImplementations()), NameOfImplementation());

}  // namespace
}  // namespace dcloc::server
