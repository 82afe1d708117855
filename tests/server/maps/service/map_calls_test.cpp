#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "server/app/storage.h"
#include "tests/server/fixtures/test_maps.h"
#include "tests/server/fixtures/test_server.h"

// Resuming, labels and places over the wire: what is refused, and who may ask.
namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class MapCallsTest : public ::testing::Test {
 protected:
  MapCallsTest() {
    for (const auto& bytes : {first_, second_}) {
      v1::UploadMapHeader header = HeaderOf(bytes);
      header.set_activate(false);
      EXPECT_TRUE(UploadMap(*server_.maps, header, bytes, &uploaded_).ok());
    }
    EXPECT_TRUE(Activate(1).ok());
  }

  template <typename Request, typename Response>
  static grpc::Status Ask(v1::MapService::Stub& stub,
                          grpc::Status (v1::MapService::Stub::*method)(grpc::ClientContext*,
                                                                       const Request&, Response*),
                          const Request& request, Response* response) {
    Call call;
    return (stub.*method)(&call, request, response);
  }

  grpc::Status Activate(std::int64_t version) {
    v1::ActivateMapVersionRequest request;
    request.set_map_name("town");
    request.set_version(version);
    v1::ActivateMapVersionResponse response;
    return Ask(*server_.maps, &v1::MapService::Stub::ActivateMapVersion, request, &response);
  }

  grpc::Status SetCanary(std::int64_t version, double share) {
    v1::SetMapCanaryRequest request;
    request.set_map_name("town");
    request.set_version(version);
    request.set_share(share);
    v1::SetMapCanaryResponse response;
    auto status = Ask(*server_.maps, &v1::MapService::Stub::SetMapCanary, request, &response);
    map_ = response.map();
    return status;
  }

  grpc::Status RollBack() {
    v1::RollBackMapRequest request;
    request.set_map_name("town");
    v1::RollBackMapResponse response;
    auto status = Ask(*server_.maps, &v1::MapService::Stub::RollBackMap, request, &response);
    map_ = response.map();
    return status;
  }

  grpc::Status FindCoverage(const v1::FindCoverageRequest& request) {
    return Ask(*server_.maps, &v1::MapService::Stub::FindCoverage, request, &coverage_);
  }

  grpc::Status ReadTile(const v1::ReadMapTileRequest& request) {
    return Ask(*server_.maps, &v1::MapService::Stub::ReadMapTile, request, &tile_);
  }

  v1::GetMapUploadResponse UploadOf(const std::vector<std::byte>& bytes) {
    v1::GetMapUploadRequest request;
    request.set_sha256(Sha256Of(bytes));
    v1::GetMapUploadResponse response;
    EXPECT_TRUE(Ask(*server_.maps, &v1::MapService::Stub::GetMapUpload, request, &response).ok());
    return response;
  }

  std::int64_t SessionsVersion(const std::string& vehicle_id) {
    TestSession session(*server_.localization);
    v1::OpenSession open = OpenMessage();
    open.set_vehicle_id(vehicle_id);
    session.Open(open);
    const auto opened = session.Read();
    EXPECT_TRUE(opened.has_value());
    return opened ? opened->opened().map_version() : 0;
  }

  static v1::ReadMapTileRequest WholeTown() {
    v1::ReadMapTileRequest request;
    request.set_map_name("town");
    request.set_min_x_m(500'000.0 - 2500.0);
    request.set_max_x_m(500'000.0 + 2500.0);
    request.set_min_y_m(5'400'000.0 - 2500.0);
    request.set_max_y_m(5'400'000.0 + 2500.0);
    return request;
  }

  static v1::FindCoverageRequest BeginOfTown() {
    v1::FindCoverageRequest request;
    request.mutable_map_place()->set_map_name("town");
    request.mutable_map_place()->set_x_m(500'200.0);
    request.mutable_map_place()->set_y_m(5'400'000.0);
    request.set_radius_m(5.0);
    return request;
  }

  const std::vector<std::byte> first_ = SmallMap("first");
  const std::vector<std::byte> second_ = SmallMap("second");
  TestServer server_;
  v1::UploadMapResponse uploaded_;
  v1::Map map_;
  v1::FindCoverageResponse coverage_;
  v1::ReadMapTileResponse tile_;
};

void ExpectInvalid(const grpc::Status& status, const std::string& part) {
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << part;
  EXPECT_THAT(status.error_message(), HasSubstr(part));
}

TEST_F(MapCallsTest, AnUploadThatBrokeOffGoesOnWhereTheServerSays) {
  const std::vector<std::byte> bytes = SmallMap("long", 2000);
  EXPECT_EQ(UploadOf(bytes).durable_size_bytes(), 0);
  {
    Call call;
    const auto writer = server_.maps->UploadMap(&call, &uploaded_);
    v1::UploadMapRequest request;
    *request.mutable_header() = HeaderOf(bytes);
    ASSERT_TRUE(writer->Write(request));
    request.mutable_chunk()->set_data(bytes.data(), 500'000);
    ASSERT_TRUE(writer->Write(request));
    ASSERT_TRUE(Eventually([&] { return UploadOf(bytes).durable_size_bytes() == 500'000; }));
    call.TryCancel();
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  Call call;
  const auto writer = server_.maps->UploadMap(&call, &uploaded_);
  v1::UploadMapRequest request;
  *request.mutable_header() = HeaderOf(bytes);
  ASSERT_TRUE(writer->Write(request));
  constexpr std::size_t kChunk = 1'000'000;
  for (std::size_t offset = 500'000; offset < bytes.size(); offset += kChunk) {
    request.mutable_chunk()->set_offset_bytes(static_cast<std::int64_t>(offset));
    request.mutable_chunk()->set_data(bytes.data() + offset,
                                      std::min(kChunk, bytes.size() - offset));
    ASSERT_TRUE(writer->Write(request));
  }
  writer->WritesDone();
  const grpc::Status status = writer->Finish();
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(uploaded_.version().version(), 3);
  EXPECT_TRUE(UploadOf(bytes).stored());
  EXPECT_EQ(UploadOf(bytes).durable_size_bytes(), 0);
}

TEST_F(MapCallsTest, AHashMustBeOne) {
  v1::GetMapUploadRequest request;
  request.set_sha256("../../etc/passwd");
  v1::GetMapUploadResponse response;
  ExpectInvalid(Ask(*server_.maps, &v1::MapService::Stub::GetMapUpload, request, &response),
                "sha256 is");
}

TEST_F(MapCallsTest, VehiclesGetWhatTheLabelsSay) {
  EXPECT_EQ(SessionsVersion("car-1"), 1);
  ASSERT_TRUE(SetCanary(2, 1.0).ok());
  EXPECT_EQ(map_.canary_version(), 2);
  EXPECT_EQ(map_.canary_share(), 1.0);
  EXPECT_EQ(SessionsVersion("car-1"), 2);
  ASSERT_TRUE(SetCanary(0, 0.0).ok());
  EXPECT_EQ(SessionsVersion("car-1"), 1);
  ASSERT_TRUE(Activate(2).ok());
  EXPECT_EQ(SessionsVersion("car-1"), 2);
  ASSERT_TRUE(RollBack().ok());
  EXPECT_EQ(map_.active_version(), 1);
  EXPECT_EQ(map_.previous_version(), 2);
  EXPECT_EQ(SessionsVersion("car-1"), 1);
}

TEST_F(MapCallsTest, BadLabelsAreRefusedByName) {
  ExpectInvalid(SetCanary(2, 0.0), "share is 0");
  ExpectInvalid(SetCanary(2, 1.5), "share is 1.5");
  ExpectInvalid(SetCanary(2, kNan), "share");
  ExpectInvalid(SetCanary(0, 0.5), "share is 0.5");
  ExpectInvalid(SetCanary(-1, 0.5), "version is -1");
  v1::RollBackMapRequest request;
  v1::RollBackMapResponse response;
  ExpectInvalid(Ask(*server_.maps, &v1::MapService::Stub::RollBackMap, request, &response),
                "map_name");
  EXPECT_EQ(RollBack().error_code(), grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(MapCallsTest, CoverageIsFoundByPlace) {
  const grpc::Status status = FindCoverage(BeginOfTown());
  ASSERT_TRUE(status.ok()) << status.error_message();
  ASSERT_EQ(coverage_.coverages_size(), 1);
  EXPECT_EQ(coverage_.coverages(0).map_name(), "town");
  EXPECT_EQ(coverage_.coverages(0).version(), 1);
  EXPECT_NEAR(coverage_.coverages(0).distance_m(), 0.0, 1e-6);
  v1::FindCoverageRequest request;
  request.mutable_position()->set_latitude_deg(52.5);
  ASSERT_TRUE(FindCoverage(request).ok());
  EXPECT_EQ(coverage_.coverages_size(), 0) << "the map has no anchor";
}

TEST_F(MapCallsTest, WhatVehiclesCanExpectIsToldWhereTheMapHasIt) {
  v1::FindCoverageRequest request = BeginOfTown();
  request.set_with_accuracy(true);
  ASSERT_TRUE(FindCoverage(request).ok());
  EXPECT_FALSE(coverage_.coverages(0).has_accuracy()) << "nobody has looked";
  ASSERT_TRUE(ReadTile(WholeTown()).ok());
  EXPECT_EQ(tile_.keyframe_accuracies_size(), 0);
  SyntheticMap map(12, 20);
  const KeyframeAccuracy::Sigmas sigmas{.along_m = 0.2, .across_m = 0.1, .heading_rad = 0.01};
  for (KeyframeRecord& keyframe : map.keyframes) {
    keyframe.accuracy = PackAccuracy({.sigmas = sigmas, .is_tunnel = false, .is_alias = true});
  }
  map.keyframes[5].accuracy = PackAccuracy({.is_tunnel = true});
  const std::vector<std::byte> bytes = map.Bytes();
  ASSERT_TRUE(UploadMap(*server_.maps, HeaderOf(bytes), bytes, &uploaded_).ok());
  ASSERT_TRUE(FindCoverage(request).ok());
  const v1::ExpectedAccuracy& here = coverage_.coverages(0).accuracy();
  EXPECT_NEAR(here.along_sigma_m(), 0.2, 0.003);
  EXPECT_NEAR(here.heading_sigma_rad(), 0.01, 0.0002);
  EXPECT_TRUE(here.is_alias());
  ASSERT_TRUE(ReadTile(WholeTown()).ok());
  ASSERT_EQ(tile_.keyframe_accuracies_size(), 12);
  EXPECT_FALSE(tile_.keyframe_accuracies(5).has_along_sigma_m()) << "no pose there";
  EXPECT_TRUE(tile_.keyframe_accuracies(5).is_tunnel());
  request.set_with_accuracy(false);
  ASSERT_TRUE(FindCoverage(request).ok());
  EXPECT_FALSE(coverage_.coverages(0).has_accuracy()) << "it was not asked for";
}

TEST_F(MapCallsTest, BadPlacesAreRefusedByName) {
  const auto expect = [&](const std::string& part,
                          const std::function<void(v1::FindCoverageRequest&)>& spoil) {
    v1::FindCoverageRequest request = BeginOfTown();
    spoil(request);
    ExpectInvalid(FindCoverage(request), part);
  };
  expect("place is missing", [](auto& r) { r.clear_map_place(); });
  expect("radius_m is -1", [](auto& r) { r.set_radius_m(-1.0); });
  expect("radius_m is 10001", [](auto& r) { r.set_radius_m(10'001.0); });
  expect("radius_m", [](auto& r) { r.set_radius_m(kNan); });
  expect("map_place.x_m", [](auto& r) { r.mutable_map_place()->set_x_m(kNan); });
  expect("map_place.y_m", [](auto& r) { r.mutable_map_place()->set_y_m(1e9); });
  expect("map_place.map_name", [](auto& r) { r.mutable_map_place()->set_map_name("a/b"); });
  expect("position: ", [](auto& r) { r.mutable_position()->set_latitude_deg(91.0); });
  v1::FindCoverageRequest elsewhere = BeginOfTown();
  elsewhere.mutable_map_place()->set_map_name("city");
  EXPECT_EQ(FindCoverage(elsewhere).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(MapCallsTest, ATileHasWhatAViewerDraws) {
  const grpc::Status status = ReadTile(WholeTown());
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(tile_.version(), 1);
  EXPECT_EQ(tile_.point_count(), 240);
  EXPECT_EQ(tile_.x_m_size(), 240);
  EXPECT_EQ(tile_.y_m_size(), 240);
  EXPECT_EQ(tile_.z_m_size(), 240);
  EXPECT_EQ(tile_.rcs_dbsm_size(), 240);
  EXPECT_EQ(tile_.keyframe_x_m_size(), 12);
  EXPECT_EQ(tile_.keyframe_y_m_size(), 12);
  EXPECT_NEAR(tile_.origin_m().x() + tile_.keyframe_x_m(0), 500'200.0, 1e-3);
  v1::ReadMapTileRequest few = WholeTown();
  few.set_max_point_count(10);
  ASSERT_TRUE(ReadTile(few).ok());
  EXPECT_LE(tile_.x_m_size(), 10);
  EXPECT_EQ(tile_.point_count(), 240);
}

TEST_F(MapCallsTest, BadTilesAreRefusedByName) {
  const auto expect = [&](const std::string& part,
                          const std::function<void(v1::ReadMapTileRequest&)>& spoil) {
    v1::ReadMapTileRequest request = WholeTown();
    spoil(request);
    ExpectInvalid(ReadTile(request), part);
  };
  expect("map_name", [](auto& r) { r.clear_map_name(); });
  expect("version is -2", [](auto& r) { r.set_version(-2); });
  expect("min_x_m", [](auto& r) { r.set_min_x_m(kNan); });
  expect("min_y_m", [](auto& r) { r.set_min_y_m(-1e9); });
  expect("max_x_m", [](auto& r) { r.set_max_x_m(r.min_x_m() - 1.0); });
  expect("max_x_m", [](auto& r) { r.set_max_x_m(r.min_x_m() + 5001.0); });
  expect("max_y_m", [](auto& r) { r.set_max_y_m(kNan); });
  expect("max_point_count is 50001", [](auto& r) { r.set_max_point_count(50'001); });
  expect("max_point_count is -1", [](auto& r) { r.set_max_point_count(-1); });
}

TEST_F(MapCallsTest, WhoMayAskIsSaidForEachCall) {
  const auto identities = *OpenIdentities(server_.folder.path() / "store");
  const auto token = [&](const std::string& name, Role role) {
    return *identities->Create(Proof::kToken, {.name = name, .role = role}, {});
  };
  const std::string vehicle = token("car", Role::kVehicle);
  const std::string viewer = token("eve", Role::kViewer);
  const std::string other = *identities->Create(
      Proof::kToken, {.name = "b", .tenant = "other", .role = Role::kOperator}, {});
  const auto code = [](const std::string& proof, auto&& make) {
    Call call;
    call.AddMetadata("authorization", "Bearer " + proof);
    return make(call).error_code();
  };
  const auto coverage = [&](Call& call) {
    return server_.maps->FindCoverage(&call, BeginOfTown(), &coverage_);
  };
  const auto tile = [&](Call& call) {
    return server_.maps->ReadMapTile(&call, WholeTown(), &tile_);
  };
  const auto roll_back = [&](Call& call) {
    v1::RollBackMapRequest request;
    request.set_map_name("town");
    v1::RollBackMapResponse response;
    return server_.maps->RollBackMap(&call, request, &response);
  };
  const auto canary = [&](Call& call) {
    v1::SetMapCanaryRequest request;
    request.set_map_name("town");
    v1::SetMapCanaryResponse response;
    return server_.maps->SetMapCanary(&call, request, &response);
  };
  const auto upload = [&](Call& call) {
    v1::GetMapUploadRequest request;
    request.set_sha256(Sha256Of(first_));
    v1::GetMapUploadResponse response;
    grpc::Status status = server_.maps->GetMapUpload(&call, request, &response);
    EXPECT_FALSE(response.stored());
    return status;
  };
  using enum grpc::StatusCode;
  EXPECT_EQ(code(vehicle, coverage), OK);
  EXPECT_EQ(code(vehicle, tile), PERMISSION_DENIED);
  EXPECT_EQ(code(viewer, tile), OK);
  EXPECT_EQ(code(viewer, roll_back), PERMISSION_DENIED);
  EXPECT_EQ(code(viewer, canary), PERMISSION_DENIED);
  EXPECT_EQ(code(viewer, upload), PERMISSION_DENIED);
  EXPECT_EQ(code(other, coverage), NOT_FOUND) << "another tenant's map";
  EXPECT_EQ(code(other, tile), NOT_FOUND);
  EXPECT_EQ(code(other, roll_back), NOT_FOUND);
  EXPECT_EQ(code(other, canary), NOT_FOUND);
  EXPECT_EQ(code(other, upload), OK) << "says nothing of another tenant's files";
}

}  // namespace
}  // namespace dcloc::server
