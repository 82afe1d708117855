#include "server/admin/identity_calls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "server/app/storage.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

class IdentityCallsTest : public ::testing::Test {
 protected:
  IdentityCallsTest()
      : identities_(*OpenIdentities(server_.folder.path() / "store")),
        admin_(Create({.name = "root"})) {}

  std::string Create(const Principal& principal) {
    return *identities_->Create(Proof::kToken, principal, {});
  }

  std::vector<v1::Identity> All(const std::string& token) {
    std::vector<v1::Identity> all;
    v1::ListIdentitiesRequest request;
    request.set_page_size(2);
    do {
      CallAs call(token);
      v1::ListIdentitiesResponse page;
      EXPECT_TRUE(server_.admin->ListIdentities(&call, request, &page).ok());
      EXPECT_LE(page.identities_size(), 2);
      all.insert(all.end(), page.identities().begin(), page.identities().end());
      request.set_page_token(page.next_page_token());
    } while (!request.page_token().empty());
    return all;
  }

  grpc::Status Revoke(const std::string& token, std::int64_t id) {
    CallAs call(token);
    v1::RevokeIdentityRequest request;
    request.set_id(id);
    v1::RevokeIdentityResponse response;
    return server_.admin->RevokeIdentity(&call, request, &response);
  }

  TestServer server_;
  const std::unique_ptr<IdentityStore> identities_;
  const std::string admin_;
};

TEST_F(IdentityCallsTest, AllAreListedInPagesWithoutTheirTokens) {
  const std::string secret = Create({.name = "car-1", .tenant = "acme", .role = Role::kVehicle});
  Create({.name = "eve", .role = Role::kViewer});
  const std::vector<v1::Identity> all = All(admin_);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[1].name(), "car-1");
  EXPECT_EQ(all[1].tenant(), "acme");
  EXPECT_EQ(all[1].role(), "vehicle");
  EXPECT_EQ(all[1].proof(), v1::IDENTITY_PROOF_TOKEN);
  EXPECT_GT(all[1].create_time().seconds(), 0);
  EXPECT_FALSE(all[1].has_revoke_time());
  for (const v1::Identity& identity : all) {
    EXPECT_EQ(identity.ShortDebugString().find(secret), std::string::npos);
  }
}

TEST_F(IdentityCallsTest, WhoIsRevokedIsNoLongerLetIn) {
  const std::string viewer = Create({.name = "eve", .role = Role::kViewer});
  const auto may_look = [&] {
    CallAs call(viewer);
    v1::ListSessionsResponse response;
    return server_.admin->ListSessions(&call, {}, &response).ok();
  };
  EXPECT_TRUE(may_look());
  EXPECT_EQ(Revoke(viewer, 2).error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_TRUE(Revoke(admin_, 2).ok());
  EXPECT_TRUE(Eventually([&] { return !may_look(); }));
  EXPECT_TRUE(All(admin_)[1].has_revoke_time());
  EXPECT_EQ(Revoke(admin_, 77).error_code(), grpc::StatusCode::NOT_FOUND);
}

}  // namespace
}  // namespace dcloc::server
