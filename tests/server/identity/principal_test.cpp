#include "server/identity/principal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

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

}  // namespace
}  // namespace dcloc::server
