#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "server/app/storage.h"
#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

// Maps that the server makes of scans at known poses.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class MapBuildsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { drive_ = std::make_unique<TownDrive>(); }
  static void TearDownTestSuite() { drive_.reset(); }

  static v1::StartMapBuildRequest Header() {
    v1::StartMapBuildRequest request;
    v1::MapBuildHeader* header = request.mutable_header();
    header->set_map_name("town");
    *header->mutable_rig() = TownDrive::RigMessage(drive_->mapping.rig);
    header->set_drive_name("mapping");
    header->set_description("by a test");
    header->set_activate(true);
    return request;
  }

  static v1::StartMapBuildRequest ScanAt(std::size_t index) {
    const DriveScan& scan = drive_->mapping.scans[index];
    v1::StartMapBuildRequest request;
    *request.mutable_scan()->mutable_scan() =
        MessageOf(scan.scan, static_cast<std::int64_t>(index));
    convert::ToProto(scan.T_map_vehicle, request.mutable_scan()->mutable_t_map_vehicle());
    return request;
  }

  static std::vector<v1::StartMapBuildRequest> WholeDrive() {
    std::vector<v1::StartMapBuildRequest> requests = {Header()};
    for (std::size_t i = 0; i < drive_->mapping.scans.size(); ++i) requests.push_back(ScanAt(i));
    return requests;
  }

  grpc::Status Start(const std::vector<v1::StartMapBuildRequest>& requests) {
    return Start(server_, requests);
  }
  grpc::Status Start(const TestServer& server,
                     const std::vector<v1::StartMapBuildRequest>& requests) {
    Call call;
    v1::StartMapBuildResponse response;
    const auto writer = server.maps->StartMapBuild(&call, &response);
    for (const auto& request : requests) {
      if (!writer->Write(request)) break;
    }
    writer->WritesDone();
    grpc::Status status = writer->Finish();
    build_ = response.build();
    return status;
  }

  v1::MapBuild Get(const std::string& build_id) {
    Call call;
    v1::GetMapBuildRequest request;
    request.set_build_id(build_id);
    v1::GetMapBuildResponse response;
    EXPECT_TRUE(server_.maps->GetMapBuild(&call, request, &response).ok());
    return response.build();
  }

  v1::MapBuild WaitFor(const std::string& build_id) {
    Eventually([&] { return Get(build_id).state() != v1::MAP_BUILD_STATE_RUNNING; });
    return Get(build_id);
  }

  grpc::Status Cancel(const std::string& build_id) {
    Call call;
    v1::CancelMapBuildRequest request;
    request.set_build_id(build_id);
    v1::CancelMapBuildResponse response;
    return server_.maps->CancelMapBuild(&call, request, &response);
  }

  v1::ListMapBuildsResponse List() {
    Call call;
    v1::ListMapBuildsResponse response;
    EXPECT_TRUE(server_.maps->ListMapBuilds(&call, {}, &response).ok());
    return response;
  }

  bool NothingIsLeft() const {
    return std::filesystem::is_empty(server_.folder.path() / "store" / "incoming");
  }

  static inline std::unique_ptr<TownDrive> drive_;
  TestServer server_;
  v1::MapBuild build_;
};

TEST_F(MapBuildsTest, ADriveBecomesAVersionInWhichVehiclesAreFound) {
  ServerConfig config;
  const TestServer server(config);
  const grpc::Status status = Start(server, WholeDrive());
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(build_.scan_count(), static_cast<std::int64_t>(drive_->mapping.scans.size()));
  EXPECT_EQ(build_.map_name(), "town");
  v1::GetMapBuildResponse response;
  ASSERT_TRUE(Eventually([&] {
    Call call;
    v1::GetMapBuildRequest request;
    request.set_build_id(build_.build_id());
    EXPECT_TRUE(server.maps->GetMapBuild(&call, request, &response).ok());
    return response.build().state() != v1::MAP_BUILD_STATE_RUNNING;
  }));
  const v1::MapBuild& done = response.build();
  ASSERT_EQ(done.state(), v1::MAP_BUILD_STATE_DONE) << done.error_message();
  EXPECT_EQ(done.done_scan_count(), done.scan_count());
  EXPECT_TRUE(done.version().active());
  EXPECT_EQ(done.version().info().drive_name(), "mapping");
  EXPECT_EQ(done.version().info().description(), "by a test");
  EXPECT_GT(done.version().info().point_count(), 100);

  TestSession session(*server.localization);
  ASSERT_TRUE(session.Open(drive_->Open()));
  ASSERT_TRUE(session.Read().has_value());
  v1::LocalizationResult last;
  for (std::size_t i = 0; i < 40; ++i) {
    last = session.Localize(MessageOf(drive_->live.scans[i].scan, static_cast<std::int64_t>(i)))
               ->result();
  }
  EXPECT_EQ(last.state(), v1::LOCALIZATION_STATE_TRACKING);
}

TEST_F(MapBuildsTest, TheSameDriveGivesTheSameFile) {
  ASSERT_TRUE(Start(WholeDrive()).ok());
  const v1::MapBuild first = WaitFor(build_.build_id());
  ASSERT_TRUE(Start(WholeDrive()).ok());
  const v1::MapBuild second = WaitFor(build_.build_id());
  EXPECT_NE(first.build_id(), second.build_id());
  EXPECT_EQ(first.version().sha256(), second.version().sha256());
  EXPECT_EQ(second.version().version(), 1) << "so it is the version that is there";
  ASSERT_EQ(List().builds_size(), 2);
  EXPECT_EQ(List().builds(0).build_id(), second.build_id()) << "newest first";
  EXPECT_TRUE(NothingIsLeft());
  EXPECT_TRUE(Eventually(
      [&] { return std::filesystem::is_empty(server_.folder.path() / "store" / "builds"); }));
}

TEST_F(MapBuildsTest, FurtherPassesBeginAnew) {
  std::vector<v1::StartMapBuildRequest> requests = WholeDrive();
  const std::size_t scan_count = requests.size() - 1;
  for (std::size_t i = 0; i < scan_count; ++i) requests.push_back(ScanAt(i));
  grpc::Status status = Start(requests);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("scan.stamp_ns"));
  requests[1 + scan_count].mutable_scan()->set_begins_pass(true);
  status = Start(requests);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(WaitFor(build_.build_id()).state(), v1::MAP_BUILD_STATE_DONE);
}

TEST_F(MapBuildsTest, ACancelledBuildAddsNoVersion) {
  std::vector<std::string> build_ids;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(Start(WholeDrive()).ok());
    build_ids.push_back(build_.build_id());
  }
  ASSERT_TRUE(Cancel(build_ids[2]).ok());
  ASSERT_TRUE(Cancel(build_ids[1]).ok());
  EXPECT_EQ(WaitFor(build_ids[2]).state(), v1::MAP_BUILD_STATE_CANCELLED);
  EXPECT_EQ(WaitFor(build_ids[0]).state(), v1::MAP_BUILD_STATE_DONE);
  EXPECT_EQ(Cancel(build_ids[0]).error_code(), grpc::StatusCode::OK) << "it has ended";
  EXPECT_EQ(Get(build_ids[0]).state(), v1::MAP_BUILD_STATE_DONE);
  EXPECT_EQ(Cancel("nobody").error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_TRUE(Eventually([&] { return NothingIsLeft(); })) << "it goes after the state is told";
}

TEST_F(MapBuildsTest, WhatGivesNoMapFailsAndSaysWhy) {
  std::vector<v1::StartMapBuildRequest> requests = {Header(), ScanAt(0)};
  requests[1].mutable_scan()->mutable_scan()->clear_range_m();
  requests[1].mutable_scan()->mutable_scan()->clear_range_rate_mps();
  requests[1].mutable_scan()->mutable_scan()->clear_azimuth_rad();
  requests[1].mutable_scan()->mutable_scan()->clear_rcs_dbsm();
  const grpc::Status status = Start(requests);
  ASSERT_TRUE(status.ok()) << status.error_message();
  const v1::MapBuild failed = WaitFor(build_.build_id());
  EXPECT_EQ(failed.state(), v1::MAP_BUILD_STATE_FAILED);
  EXPECT_EQ(failed.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_FALSE(failed.error_message().empty());
  EXPECT_FALSE(failed.has_version());
}

TEST_F(MapBuildsTest, MalformedOnesAreRefusedByNameAndLeaveNothing) {
  const auto expect = [&](const std::string& part,
                          const std::vector<v1::StartMapBuildRequest>& requests) {
    const grpc::Status status = Start(requests);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << part;
    EXPECT_THAT(status.error_message(), HasSubstr(part));
  };
  const auto header = [](const std::function<void(v1::MapBuildHeader&)>& spoil) {
    v1::StartMapBuildRequest request = Header();
    spoil(*request.mutable_header());
    return std::vector{request, ScanAt(0)};
  };
  const auto scan = [](const std::function<void(v1::PosedScan&)>& spoil) {
    v1::StartMapBuildRequest request = ScanAt(1);
    spoil(*request.mutable_scan());
    return std::vector{Header(), ScanAt(0), request};
  };
  expect("header is missing", {});
  expect("header is missing", {ScanAt(0)});
  expect("scan is missing", {Header()});
  expect("scan is missing", {Header(), Header()});
  expect("header.map_name", header([](auto& h) { h.set_map_name("A b"); }));
  expect("header.rig", header([](auto& h) { h.clear_rig(); }));
  expect("header.drive_name", header([](auto& h) { h.set_drive_name(std::string(1001, 'x')); }));
  expect("header.description", header([](auto& h) { h.set_description(std::string(1001, 'x')); }));
  expect("header.anchor",
         header([](auto& h) { h.mutable_anchor()->mutable_origin()->set_latitude_deg(91.0); }));
  expect("header.anchor", header([](auto& h) {
           h.mutable_anchor()->set_x_axis_east_rad(std::numeric_limits<double>::infinity());
         }));
  expect("scan 1: t_map_vehicle is missing", scan([](auto& s) { s.clear_t_map_vehicle(); }));
  expect("t_map_vehicle.rotation is 7",
         scan([](auto& s) { s.mutable_t_map_vehicle()->mutable_rotation()->set_w(7.0); }));
  expect("scan 1: scan.radar_id", scan([](auto& s) { s.mutable_scan()->set_radar_id("rear"); }));
  expect("scan 1: scan.", scan([](auto& s) { s.mutable_scan()->clear_azimuth_rad(); }));
  expect("scan 1: scan.stamp_ns", scan([](auto& s) { s.mutable_scan()->set_stamp_ns(1); }));
  EXPECT_EQ(List().builds_size(), 0);
  EXPECT_TRUE(NothingIsLeft());
}

TEST_F(MapBuildsTest, TooMuchIsRefusedByTheLimitsName) {
  ServerConfig config = TestServer::StubConfig();
  config.max_map_mib = 1;
  const TestServer server(config);
  std::vector<v1::StartMapBuildRequest> requests = {Header()};
  std::int64_t size_bytes = 0;
  for (std::size_t i = 0; size_bytes < 2 << 20; ++i) {
    requests.push_back(ScanAt(i % drive_->mapping.scans.size()));
    requests.back().mutable_scan()->set_begins_pass(true);
    size_bytes += static_cast<std::int64_t>(requests.back().ByteSizeLong());
  }
  const grpc::Status status = Start(server, requests);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("max_map_mib"));
}

TEST_F(MapBuildsTest, ATenantHasOnlySoManyUnderWay) {
  std::vector<std::string> build_ids;
  grpc::Status status;
  for (int i = 0; i < 50 && status.ok(); ++i) {
    status = Start(WholeDrive());
    if (status.ok()) build_ids.push_back(build_.build_id());
  }
  if (status.ok()) GTEST_SKIP() << "the builds end faster than they are started";
  EXPECT_GE(build_ids.size(), 4U);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(status.error_message(), HasSubstr("4 builds"));
  for (const std::string& build_id : build_ids) EXPECT_TRUE(Cancel(build_id).ok());
}

TEST_F(MapBuildsTest, AnInterruptedCallLeavesNothing) {
  {
    Call call;
    v1::StartMapBuildResponse response;
    const auto writer = server_.maps->StartMapBuild(&call, &response);
    ASSERT_TRUE(writer->Write(Header()));
    ASSERT_TRUE(writer->Write(ScanAt(0)));
    ASSERT_TRUE(Eventually([&] { return !NothingIsLeft(); }));
    call.TryCancel();
    EXPECT_EQ(writer->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
  EXPECT_TRUE(Eventually([&] { return NothingIsLeft(); }));
  EXPECT_EQ(List().builds_size(), 0);
}

TEST_F(MapBuildsTest, WhoMayIsSaidAndTenantsDoNotSeeEachOthers) {
  ASSERT_TRUE(Start(WholeDrive()).ok());
  const std::string build_id = build_.build_id();
  const auto identities = *OpenIdentities(server_.folder.path() / "store");
  const std::string viewer =
      *identities->Create(Proof::kToken, {.name = "eve", .role = Role::kViewer}, {});
  const std::string other = *identities->Create(
      Proof::kToken, {.name = "b", .tenant = "other", .role = Role::kOperator}, {});
  const auto get = [&](const std::string& token) {
    Call call;
    call.AddMetadata("authorization", "Bearer " + token);
    v1::GetMapBuildRequest request;
    request.set_build_id(build_id);
    v1::GetMapBuildResponse response;
    return server_.maps->GetMapBuild(&call, request, &response).error_code();
  };
  const auto cancel = [&](const std::string& token) {
    Call call;
    call.AddMetadata("authorization", "Bearer " + token);
    v1::CancelMapBuildRequest request;
    request.set_build_id(build_id);
    v1::CancelMapBuildResponse response;
    return server_.maps->CancelMapBuild(&call, request, &response).error_code();
  };
  const auto start = [&](const std::string& token) {
    Call call;
    call.AddMetadata("authorization", "Bearer " + token);
    v1::StartMapBuildResponse response;
    const auto writer = server_.maps->StartMapBuild(&call, &response);
    writer->Write(Header());
    writer->WritesDone();
    return writer->Finish().error_code();
  };
  using enum grpc::StatusCode;
  EXPECT_EQ(get(viewer), OK);
  EXPECT_EQ(cancel(viewer), PERMISSION_DENIED);
  EXPECT_EQ(start(viewer), PERMISSION_DENIED);
  EXPECT_EQ(get(other), NOT_FOUND);
  EXPECT_EQ(cancel(other), NOT_FOUND);
}

}  // namespace
}  // namespace dcloc::server
