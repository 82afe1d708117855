#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "dcloc/v1/admin_service.pb.h"
#include "dcloc/v1/localization_service.pb.h"
#include "dcloc/v1/map_service.pb.h"
#include "server/base/sha256.h"
#include "server/identity/identity_store.h"
#include "server/identity/method_permissions.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// ---- Roles and methods

TEST(RoleTest, EachRoleMayDoWhatTheOneBelowMayAndVehiclesOnlyDrive) {
  EXPECT_TRUE(Grants(Role::kVehicle, "", Permission::kLocalize));
  EXPECT_TRUE(Grants(Role::kVehicle, "", Permission::kReadCoverage));
  for (const Permission permission :
       {Permission::kReadMaps, Permission::kManageMaps, Permission::kReadSessions,
        Permission::kManageSessions, Permission::kReadServer, Permission::kManageServer}) {
    EXPECT_FALSE(Grants(Role::kVehicle, "", permission)) << NameOf(permission);
    EXPECT_TRUE(Grants(Role::kAdmin, "", permission)) << NameOf(permission);
  }
  EXPECT_TRUE(Grants(Role::kViewer, "", Permission::kReadMaps));
  EXPECT_FALSE(Grants(Role::kViewer, "", Permission::kManageMaps));
  EXPECT_FALSE(Grants(Role::kViewer, "", Permission::kLocalize));
  EXPECT_TRUE(Grants(Role::kOperator, "", Permission::kManageMaps));
  EXPECT_FALSE(Grants(Role::kOperator, "", Permission::kManageServer));
}

TEST(RoleTest, OnlyTheDefaultTenantSeesTheServerAsAWhole) {
  EXPECT_TRUE(Grants(Role::kAdmin, "acme", Permission::kManageMaps));
  EXPECT_FALSE(Grants(Role::kAdmin, "acme", Permission::kReadServer));
  EXPECT_FALSE(Grants(Role::kAdmin, "acme", Permission::kManageServer));
}

TEST(RoleTest, NamesGoBothWays) {
  for (const Role role : kRoles) EXPECT_EQ(RoleFromName(NameOf(role)), role);
  EXPECT_EQ(RoleFromName("root"), std::nullopt);
}

TEST(MethodPermissionsTest, EveryMethodOfTheContractHasExactlyOneEntry) {
  // A static library's descriptors are there once something in it is used.
  for (const auto* used : {v1::ListMapsRequest::descriptor(), v1::LocalizeRequest::descriptor(),
                           v1::GetServerStateRequest::descriptor()}) {
    ASSERT_NE(used, nullptr);
  }
  std::multiset<std::string> listed;
  for (const MethodPermission& entry : MethodPermissions()) listed.insert(entry.method);
  std::set<std::string> served;
  std::set<const google::protobuf::Descriptor*> requests;
  for (const auto& file : std::filesystem::directory_iterator(DCLOC_PROTO_FOLDER "/dcloc/v1")) {
    const auto* descriptor = google::protobuf::DescriptorPool::generated_pool()->FindFileByName(
        "dcloc/v1/" + file.path().filename().string());
    ASSERT_NE(descriptor, nullptr) << file.path();
    for (int s = 0; s < descriptor->service_count(); ++s) {
      for (int m = 0; m < descriptor->service(s)->method_count(); ++m) {
        const auto* method = descriptor->service(s)->method(m);
        served.insert(method->full_name());
        EXPECT_EQ(listed.count(method->full_name()), 1U)
            << method->full_name() << " needs an entry in method_permissions.cpp";
        EXPECT_TRUE(requests.insert(method->input_type()).second)
            << method->full_name() << " shares its request; permissions are found by request";
      }
    }
  }
  EXPECT_GE(served.size(), 12U);
  for (const std::string& method : listed) EXPECT_TRUE(served.contains(method)) << method;
}

TEST(PrincipalTest, TenantsNamesCannotMeet) {
  EXPECT_EQ(ScopedMapName("", "town"), "town");
  EXPECT_EQ(ScopedMapName("acme", "town"), "acme/town");
  EXPECT_EQ(UnscopedMapName("acme/town"), "town");
  EXPECT_EQ(UnscopedMapName("town"), "town");
}

TEST(PrincipalTest, AVehicleIsOnlyItself) {
  const Principal car{.name = "car-1", .role = Role::kVehicle};
  EXPECT_TRUE(CheckVehicle(car, "car-1").ok());
  const absl::Status status = CheckVehicle(car, "car-2");
  EXPECT_EQ(status.code(), absl::StatusCode::kPermissionDenied);
  EXPECT_THAT(MessageOf(status), AllOf(HasSubstr("car-2"), HasSubstr("car-1")));
  EXPECT_TRUE(CheckVehicle({.name = "ops", .role = Role::kOperator}, "car-2").ok());
}

// ---- The store

class IdentityStoreTest : public ::testing::Test {
 protected:
  std::unique_ptr<IdentityStore> Open() const {
    absl::StatusOr<std::unique_ptr<IdentityStore>> store =
        IdentityStore::Open(IdentityFile(folder_.path()));
    EXPECT_TRUE(store.ok()) << store.status();
    return *std::move(store);
  }

  static SystemTime In(std::chrono::seconds duration) {
    return std::chrono::system_clock::now() + duration;
  }

  TemporaryFolder folder_;
  std::unique_ptr<IdentityStore> store_ = Open();
};

TEST_F(IdentityStoreTest, ATokenIsItsPrincipal) {
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

TEST_F(IdentityStoreTest, OnlyTheHashIsAtRest) {
  const std::string token = *store_->Create(Proof::kToken, {.name = "ops"}, {});
  store_.reset();  // writes everything into the file
  std::ifstream file(IdentityFile(folder_.path()), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  Sha256 hash;
  hash.Update(std::as_bytes(std::span(token)));
  EXPECT_THAT(bytes, AllOf(Not(HasSubstr(token)), HasSubstr(hash.Finish())));
}

TEST_F(IdentityStoreTest, ExpiredAndRevokedTokensSaySo) {
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

TEST_F(IdentityStoreTest, AnotherProcessesChangesHoldAtOnce) {
  const std::unique_ptr<IdentityStore> other = Open();
  const std::string token = *other->Create(Proof::kToken, {.name = "a"}, {});
  EXPECT_TRUE(store_->FindToken(token).ok());
  EXPECT_TRUE(*store_->HasAny());
  ASSERT_TRUE(other->Revoke(1).ok());
  EXPECT_FALSE(store_->FindToken(token).ok());
}

TEST_F(IdentityStoreTest, CertificatesAreFoundByCommonName) {
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

TEST_F(IdentityStoreTest, BadNamesAreRefusedByName) {
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

}  // namespace
}  // namespace dcloc::server
