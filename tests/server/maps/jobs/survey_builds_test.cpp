#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/mapping/survey_builder.h"
#include "server/maps/catalogue/sqlite_build_queue.h"
#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

// Maps that the server makes of drives without poses.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;
using Message = v1::StartMapBuildRequest;

/// The drive that a survey on this machine reads.
class OneDrive final : public DriveSource, public DriveReader {
 public:
  explicit OneDrive(const Drive& drive) : drive_(drive) {}
  std::size_t drive_count() const override { return 1; }
  absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t /*drive*/) override {
    return std::make_unique<OneDrive>(drive_);
  }
  const std::string& name() const override { return name_; }
  const Rig& rig() const override { return drive_.rig; }
  std::size_t scan_count() const override { return drive_.scans.size(); }
  absl::StatusOr<const Scan*> Next() override {
    return next_ == drive_.scans.size() ? nullptr : &drive_.scans[next_++].scan;
  }

 private:
  const Drive& drive_;
  const std::string name_ = "map";
  std::size_t next_ = 0;
};

class SurveyBuildsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { drive_ = std::make_unique<TownDrive>(); }
  static void TearDownTestSuite() { drive_.reset(); }

  static Message Header() {
    Message message;
    message.mutable_header()->set_map_name("town");
    message.mutable_header()->set_method(v1::MAP_BUILD_METHOD_SURVEY);
    message.mutable_header()->set_activate(true);
    return message;
  }

  static void Append(const std::string& name, const Drive& drive, std::size_t scan_count,
                     std::vector<Message>& messages) {
    Message message;
    message.mutable_drive()->set_name(name);
    *message.mutable_drive()->mutable_rig() = TownDrive::RigMessage(drive.rig);
    messages.push_back(message);
    for (std::size_t i = 0; i < scan_count; ++i) {
      Message& scan = messages.emplace_back();
      *scan.mutable_scan()->mutable_scan() =
          MessageOf(drive.scans[i].scan, static_cast<std::int64_t>(i));
    }
  }

  static std::vector<Message> Whole() {
    std::vector<Message> messages = {Header()};
    Append("map", drive_->mapping, drive_->mapping.scans.size(), messages);
    return messages;
  }

  static v1::MapBuild Start(const TestServer& server, const std::vector<Message>& messages) {
    Call call;
    v1::StartMapBuildResponse response;
    const auto writer = server.maps->StartMapBuild(&call, &response);
    for (const Message& message : messages) {
      if (!writer->Write(message)) break;
    }
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.build();
  }

  static v1::MapBuild Get(const TestServer& server, const std::string& build_id) {
    Call call;
    v1::GetMapBuildRequest request;
    request.set_build_id(build_id);
    v1::GetMapBuildResponse response;
    const grpc::Status status = server.maps->GetMapBuild(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.build();
  }

  static v1::MapBuild WaitFor(const TestServer& server, const std::string& build_id) {
    for (int i = 0; i < 10; ++i) {
      if (Eventually(
              [&] { return Get(server, build_id).state() != v1::MAP_BUILD_STATE_RUNNING; })) {
        break;
      }
    }
    return Get(server, build_id);
  }

  static inline std::unique_ptr<TownDrive> drive_;
};

TEST_F(SurveyBuildsTest, GivesTheFileThatASurveyOnThisMachineGives) {
  OneDrive source(drive_->mapping);
  SurveyBuilder builder(source, [](const char*, double) { return true; });
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  ASSERT_TRUE(builder.Calibrate({}).ok());
  ASSERT_TRUE(builder.CorrectScale().ok());
  const auto bytes = builder.Fuse({.name = "map", .description = "survey of map"});
  ASSERT_TRUE(bytes.ok()) << bytes.status();

  const TestServer server;
  const v1::MapBuild done = WaitFor(server, Start(server, Whole()).build_id());
  ASSERT_EQ(done.state(), v1::MAP_BUILD_STATE_DONE) << done.error_message();
  EXPECT_EQ(done.version().sha256(), Sha256Of(*bytes));
  EXPECT_TRUE(done.version().active());
  EXPECT_EQ(done.method(), v1::MAP_BUILD_METHOD_SURVEY);
  EXPECT_EQ(done.attempt_count(), 1);
  EXPECT_EQ(done.done_scan_count(), done.scan_count());
  ASSERT_EQ(done.drives_size(), 1);
  EXPECT_TRUE(done.drives(0).in_map());
  EXPECT_EQ(done.drives(0).name(), "map");
  EXPECT_NEAR(done.drives(0).length_m(), 200.0, 10.0);
}

TEST_F(SurveyBuildsTest, ADriveThatIsOfNoUseIsLeftOutAndTheReasonSaid) {
  std::vector<Message> messages = Whole();
  Append("stub", drive_->live, 8, messages);
  const TestServer server;
  const v1::MapBuild done = WaitFor(server, Start(server, messages).build_id());
  ASSERT_EQ(done.state(), v1::MAP_BUILD_STATE_DONE) << done.error_message();
  ASSERT_EQ(done.drives_size(), 2);
  EXPECT_FALSE(done.drives(1).in_map());
  EXPECT_THAT(done.drives(1).reason(), HasSubstr("moved"));
  EXPECT_EQ(done.done_scan_count(), done.scan_count() - 8);
}

TEST_F(SurveyBuildsTest, WhereNoDriveIsOfUseTheErrorSaysWhichAndWhy) {
  std::vector<Message> messages = {Header()};
  Append("stub", drive_->live, 8, messages);
  const TestServer server;
  const v1::MapBuild failed = WaitFor(server, Start(server, messages).build_id());
  EXPECT_EQ(failed.state(), v1::MAP_BUILD_STATE_FAILED);
  EXPECT_EQ(failed.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(failed.error_message(), HasSubstr("stub: it moved"));
}

TEST_F(SurveyBuildsTest, AServerThatStopsGoesOnWhenItStartsAgain) {
  TestServer server;
  ServerConfig config = TestServer::StubConfig();
  config.data = server.folder.path() / "store";
  config.listen = "127.0.0.1:0";
  const std::string build_id = Start(server, Whole()).build_id();
  server.server.reset();
  server.server = *Server::Start(config);
  server.maps = v1::MapService::NewStub(
      grpc::CreateChannel(server.server->address(), grpc::InsecureChannelCredentials()));
  const v1::MapBuild done = WaitFor(server, build_id);
  EXPECT_EQ(done.state(), v1::MAP_BUILD_STATE_DONE) << done.error_message();
  EXPECT_EQ(done.attempt_count(), 1) << "it was given back";
  EXPECT_TRUE(Eventually(
      [&] { return std::filesystem::is_empty(server.folder.path() / "store" / "builds"); }));
}

TEST_F(SurveyBuildsTest, WhatAnAttemptSaidThatDidNotEndIsForgotten) {
  TestServer server;
  ServerConfig config = TestServer::StubConfig();
  config.data = server.folder.path() / "store";
  config.listen = "127.0.0.1:0";
  const std::string build_id = Start(server, Whole()).build_id();
  server.server.reset();
  {
    const auto queue = *SqliteBuildQueue::Open(server.folder.path() / "store" / "jobs.sqlite");
    const auto row = *queue->Take("dead:1");
    ASSERT_TRUE(row.has_value());
    v1::MapBuild report;
    ASSERT_TRUE(report.ParseFromString(row->report));
    report.add_drives()->set_name("of the attempt");
    report.add_radars()->set_radar_id("of the attempt");
    report.mutable_update()->set_added_count(1);
    const BuildLease lease{.build_id = build_id, .holder = "dead:1", .attempt = row->attempt_count};
    ASSERT_TRUE(queue->Renew(lease, report.SerializeAsString()).ok());
    ASSERT_TRUE(queue->GiveBack(lease).ok());
  }
  server.server = *Server::Start(config);
  server.maps = v1::MapService::NewStub(
      grpc::CreateChannel(server.server->address(), grpc::InsecureChannelCredentials()));
  const v1::MapBuild done = WaitFor(server, build_id);
  ASSERT_EQ(done.state(), v1::MAP_BUILD_STATE_DONE) << done.error_message();
  ASSERT_EQ(done.drives_size(), 1);
  EXPECT_EQ(done.drives(0).name(), "map");
  ASSERT_EQ(done.radars_size(), 1);
  EXPECT_EQ(done.radars(0).radar_id(), drive_->mapping.rig.radars[0].id);
  EXPECT_FALSE(done.has_update());
}

TEST_F(SurveyBuildsTest, WhatEndsServersIsGivenUp) {
  TestServer server;
  ServerConfig config = TestServer::StubConfig();
  config.data = server.folder.path() / "store";
  config.listen = "127.0.0.1:0";
  server.server.reset();
  {
    const auto queue = *SqliteBuildQueue::Open(server.folder.path() / "store" / "jobs.sqlite");
    ASSERT_TRUE(queue->Add({.build_id = "x", .map_name = "town"}, 4).ok());
    for (const char* const dead : {"a:1", "b:1", "c:1"}) {
      ASSERT_TRUE(queue->Take(dead)->has_value()) << dead;
    }
  }
  server.server = *Server::Start(config);
  server.maps = v1::MapService::NewStub(
      grpc::CreateChannel(server.server->address(), grpc::InsecureChannelCredentials()));
  const v1::MapBuild failed = WaitFor(server, "x");
  EXPECT_EQ(failed.state(), v1::MAP_BUILD_STATE_FAILED);
  EXPECT_EQ(failed.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_THAT(failed.error_message(), HasSubstr("3 servers ended"));
}

}  // namespace
}  // namespace dcloc::server
