#include "server/identity/identity_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const SystemTime kNow{std::chrono::hours(1'000'000)};

TEST(IdentityRulesTest, APrincipalNeedsANameAndMayHaveATenant) {
  EXPECT_TRUE(CheckPrincipal({.name = "car-7", .tenant = ""}).ok());
  EXPECT_TRUE(CheckPrincipal({.name = "car-7", .tenant = "acme"}).ok());
  EXPECT_THAT(MessageOf(CheckPrincipal({.name = "", .tenant = ""})), HasSubstr("name is"));
  EXPECT_THAT(MessageOf(CheckPrincipal({.name = "car-7", .tenant = "a/b"})),
              HasSubstr("tenant is"));
}

TEST(IdentityRulesTest, AnUnknownRoleIsDamageAndNeverAVehicle) {
  EXPECT_EQ(RoleOfIdentity(3, "ann", "operator").value_or(Role::kVehicle), Role::kOperator);
  const absl::Status status = RoleOfIdentity(3, "ann", "root").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(MessageOf(status),
              AllOf(HasSubstr("identity 3"), HasSubstr("ann"), HasSubstr("root")));
}

TEST(IdentityRulesTest, AProofHoldsUntilItExpiresOrIsRevoked) {
  IdentityRecord record;
  record.principal.name = "ann";
  EXPECT_EQ(ValidPrincipal(record, ProofByToken(), kNow)->name, "ann");
  record.expire_time = kNow + std::chrono::seconds(1);
  EXPECT_TRUE(ValidPrincipal(record, ProofByToken(), kNow).ok());
  record.expire_time = kNow;
  EXPECT_EQ(ValidPrincipal(record, ProofByToken(), kNow).status(),
            absl::UnauthenticatedError("the token has expired"));
  record.revoke_time = kNow - std::chrono::seconds(1);
  EXPECT_EQ(ValidPrincipal(record, ProofByCertificate("ann"), kNow).status(),
            absl::UnauthenticatedError("the certificate of \"ann\" was revoked"));
}

}  // namespace
}  // namespace dcloc::server
