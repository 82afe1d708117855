#include "server/identity/role.h"

#include <gtest/gtest.h>

#include <optional>

namespace dcloc::server {
namespace {

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

}  // namespace
}  // namespace dcloc::server
