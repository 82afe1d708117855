#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/app/storage.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class AccessTest : public ::testing::Test {
 protected:
  AccessTest()
      : store_(*OpenIdentities(server_.folder.path() / "store")),
        admin_(Token({.name = "admin"})) {}

  std::string Token(const Principal& principal) {
    return *store_->Create(Proof::kToken, principal, {});
  }

  grpc::Status Upload(const std::string& token, const std::string& map_name) {
    const std::vector<std::byte> bytes = SmallMap();
    CallAs call(token);
    v1::UploadMapResponse response;
    const auto writer = server_.maps->UploadMap(&call, &response);
    v1::UploadMapRequest request;
    *request.mutable_header() = HeaderOf(bytes);
    request.mutable_header()->set_map_name(map_name);
    writer->Write(request);
    request.mutable_chunk()->set_data(bytes.data(), bytes.size());
    writer->Write(request);
    writer->WritesDone();
    return writer->Finish();
  }

  std::vector<std::string> MapsSeenBy(const std::string& token, const std::string& prefix = "") {
    CallAs call(token);
    v1::ListMapsRequest request;
    request.set_name_prefix(prefix);
    v1::ListMapsResponse response;
    const grpc::Status status = server_.maps->ListMaps(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    std::vector<std::string> names;
    for (const v1::Map& map : response.maps()) names.push_back(map.name());
    return names;
  }

  grpc::Status List(const std::string& token) {
    CallAs call(token);
    v1::ListMapsResponse response;
    return server_.maps->ListMaps(&call, {}, &response);
  }

  TestServer server_;
  std::unique_ptr<IdentityStore> store_;
  std::string admin_;
};

TEST_F(AccessTest, WithoutIdentitiesEveryoneIsAnAdmin) {
  const TestServer open;
  Call call;
  v1::ListMapsResponse response;
  EXPECT_TRUE(open.maps->ListMaps(&call, {}, &response).ok());
  ServerConfig config = TestServer::StubConfig();
  config.require_identity = true;
  const TestServer closed(config);
  Call refused;
  EXPECT_EQ(closed.maps->ListMaps(&refused, {}, &response).error_code(),
            grpc::StatusCode::UNAUTHENTICATED);
}

TEST_F(AccessTest, TheProofMustBeGood) {
  EXPECT_TRUE(List(admin_).ok());
  grpc::Status status = List("");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_THAT(status.error_message(), HasSubstr("Bearer"));
  EXPECT_EQ(List("dcloc_wrong").error_code(), grpc::StatusCode::UNAUTHENTICATED);
  Call call;
  call.AddMetadata("authorization", "Basic " + admin_);
  v1::ListMapsResponse response;
  EXPECT_EQ(server_.maps->ListMaps(&call, {}, &response).error_code(),
            grpc::StatusCode::UNAUTHENTICATED);
  ASSERT_TRUE(store_->Revoke(1).ok());
  status = List(admin_);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_THAT(status.error_message(), HasSubstr("revoked"));
}

TEST_F(AccessTest, DenialsNameThePermission) {
  const std::string car = Token({.name = "car-1", .role = Role::kVehicle});
  const std::string viewer = Token({.name = "eve", .role = Role::kViewer});
  const std::string ops = Token({.name = "ops", .role = Role::kOperator});
  grpc::Status status = List(car);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(status.error_message(),
              AllOf(HasSubstr("read_maps"), HasSubstr("car-1"), HasSubstr("vehicle")));
  EXPECT_TRUE(List(viewer).ok());
  status = Upload(viewer, "town");
  EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_THAT(status.error_message(), HasSubstr("manage_maps"));
  EXPECT_TRUE(Upload(ops, "town").ok());

  CallAs call(car);
  v1::DownloadMapRequest request;
  request.set_map_name("town");
  const auto reader = server_.maps->DownloadMap(&call, request);
  v1::DownloadMapResponse message;
  EXPECT_FALSE(reader->Read(&message));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::PERMISSION_DENIED);
}

TEST_F(AccessTest, TenantsSeeOnlyTheirOwnMaps) {
  const std::string acme = Token({.name = "a", .tenant = "acme", .role = Role::kOperator});
  const std::string other = Token({.name = "b", .tenant = "other", .role = Role::kOperator});
  ASSERT_TRUE(Upload(acme, "town").ok());
  ASSERT_TRUE(Upload(acme, "village").ok());
  ASSERT_TRUE(Upload(admin_, "hill").ok());
  EXPECT_THAT(MapsSeenBy(acme), ElementsAre("town", "village"));
  EXPECT_THAT(MapsSeenBy(acme, "to"), ElementsAre("town"));
  EXPECT_THAT(MapsSeenBy(other), ElementsAre());
  EXPECT_THAT(MapsSeenBy(admin_), ElementsAre("hill"));

  v1::DeleteMapRequest request;
  request.set_map_name("town");
  v1::DeleteMapResponse response;
  CallAs foreign(other);
  EXPECT_EQ(server_.maps->DeleteMap(&foreign, request, &response).error_code(),
            grpc::StatusCode::NOT_FOUND);
  CallAs sneaky(other);
  request.set_map_name("acme/town");
  EXPECT_EQ(server_.maps->DeleteMap(&sneaky, request, &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  ASSERT_TRUE(Upload(other, "town").ok()) << "the same name is another map";
  CallAs own(acme);
  request.set_map_name("town");
  EXPECT_TRUE(server_.maps->DeleteMap(&own, request, &response).ok());
  EXPECT_THAT(MapsSeenBy(other), ElementsAre("town"));
}

TEST_F(AccessTest, WhoMayManageTheServerEntersTenantsAndNobodyElseDoes) {
  const std::string acme = Token({.name = "a", .tenant = "acme", .role = Role::kAdmin});
  const std::string ops = Token({.name = "ops", .role = Role::kOperator});
  ASSERT_TRUE(Upload(acme, "town").ok());
  const auto list_in = [this](const std::string& token, const std::string& tenant,
                              v1::ListMapsResponse* response) {
    CallAs call(token);
    call.AddMetadata("dcloc-tenant", tenant);
    return server_.maps->ListMaps(&call, {}, response);
  };
  v1::ListMapsResponse response;
  ASSERT_TRUE(list_in(admin_, "acme", &response).ok());
  ASSERT_EQ(response.maps_size(), 1);
  EXPECT_EQ(response.maps(0).name(), "town");
  ASSERT_TRUE(list_in(admin_, "nobody", &response).ok());
  EXPECT_EQ(response.maps_size(), 0);
  EXPECT_EQ(list_in(admin_, "acme/town", &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_TRUE(list_in(acme, "acme", &response).ok()) << "its own";
  for (const auto& [token, tenant] : {std::pair(acme, "other"), std::pair(ops, "acme")}) {
    const grpc::Status status = list_in(token, tenant, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED);
    EXPECT_THAT(status.error_message(), HasSubstr("manage_server"));
  }
}

TEST_F(AccessTest, UploadsBeyondALimitNameIt) {
  ServerConfig config = TestServer::StubConfig();
  config.max_map_mib = 1;
  config.max_tenant_storage_mib = 1;
  const TestServer server(config);
  const std::vector<std::byte> big = SmallMap("big", 3000);
  v1::UploadMapResponse response;
  grpc::Status status = UploadMap(*server.maps, HeaderOf(big), big, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("[1, 1048576]"));
  const std::vector<std::byte> half = SmallMap("half", 600);
  ASSERT_GT(half.size(), 1U << 19);
  ASSERT_LT(half.size(), 1U << 20);
  ASSERT_TRUE(UploadMap(*server.maps, HeaderOf(half), half, &response).ok());
  const std::vector<std::byte> more = SmallMap("more", 600);
  status = UploadMap(*server.maps, HeaderOf(more), more, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("max_tenant_storage_mib is 1"));

  config.max_map_mib = 16;
  config.max_tenant_storage_mib = 0;
  ASSERT_TRUE(server.server
                  ->Reload([&] {
                    config.data = server.folder.path() / "store";
                    config.listen = "127.0.0.1:0";
                    return config;
                  }())
                  .ok());
  EXPECT_TRUE(UploadMap(*server.maps, HeaderOf(big), big, &response).ok())
      << "new limits hold at once";
}

TEST_F(AccessTest, AMessageBeyondItsLimitIsRefused) {
  ServerConfig config = TestServer::StubConfig();
  config.max_message_kib = 512;
  const TestServer server(config);
  const std::vector<std::byte> bytes = SmallMap("big", 1000);
  ASSERT_GT(bytes.size(), 600U << 10);
  v1::UploadMapResponse response;
  const grpc::Status status = UploadMap(*server.maps, HeaderOf(bytes), bytes, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr(std::to_string(512 << 10)));
  EXPECT_TRUE(UploadMap(*server.maps, HeaderOf(bytes), bytes, &response, 400 << 10).ok());
}

}  // namespace
}  // namespace dcloc::server
