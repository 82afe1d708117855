#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/app/replica.h"
#include "tests/server/fixtures/postgres_cluster.h"
#include "tests/server/fixtures/town_drive.h"

// Builds of two processes of the server on one database and one folder of map files.
namespace dcloc::server {
namespace {

using Clock = std::chrono::steady_clock;
using Message = v1::StartMapBuildRequest;

class BuildReplicasTest : public ::testing::Test {
 protected:
  void SetUp() override {
    DCLOC_SKIP_WITHOUT_POSTGRES();
    database_ = PostgresCluster::Get().NewDatabase();
    a_ = Start("a");
  }

  std::unique_ptr<Replica> Start(const std::string& name) const {
    return std::make_unique<Replica>(
        folder_.path(), name,
        std::vector<std::string>{"--catalogue", database_, "--map-folder",
                                 (folder_.path() / "shared").string()});
  }

  /// A survey that takes some seconds: the same drive under several names.
  static v1::MapBuild Begin(Replica& replica, int drive_count) {
    const TownDrive town(400.0);
    Call call;
    v1::StartMapBuildResponse response;
    const auto writer = replica.maps->StartMapBuild(&call, &response);
    Message message;
    message.mutable_header()->set_map_name("town");
    message.mutable_header()->set_method(v1::MAP_BUILD_METHOD_SURVEY);
    writer->Write(message);
    for (int k = 0; k < drive_count; ++k) {
      message.mutable_drive()->set_name("drive-" + std::to_string(k));
      *message.mutable_drive()->mutable_rig() = TownDrive::RigMessage(town.mapping.rig);
      writer->Write(message);
      for (std::size_t i = 0; i < town.mapping.scans.size(); ++i) {
        *message.mutable_scan()->mutable_scan() =
            MessageOf(town.mapping.scans[i].scan, static_cast<std::int64_t>(i));
        writer->Write(message);
      }
    }
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.build();
  }

  static v1::MapBuild Get(Replica& replica, const std::string& build_id) {
    Call call;
    v1::GetMapBuildRequest request;
    request.set_build_id(build_id);
    v1::GetMapBuildResponse response;
    const grpc::Status status = replica.maps->GetMapBuild(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.build();
  }

  template <typename Predicate>
  static bool Within(std::chrono::seconds time, Predicate done) {
    const Clock::time_point end = Clock::now() + time;
    while (!done()) {
      if (Clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
  }

  static std::size_t Count(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
  }

  TemporaryFolder folder_;
  std::string database_;
  std::unique_ptr<Replica> a_, b_;
};

TEST_F(BuildReplicasTest, WhatAKilledOneBuiltAnotherBuildsAnew) {
  const std::string build_id = Begin(*a_, 6).build_id();
  ASSERT_TRUE(Within(std::chrono::seconds(60), [&] { return !Get(*a_, build_id).stage().empty(); }))
      << "it is being built";
  a_->Kill();
  b_ = Start("b");
  EXPECT_EQ(Get(*b_, build_id).state(), v1::MAP_BUILD_STATE_RUNNING);
  ASSERT_TRUE(Within(std::chrono::seconds(180),
                     [&] { return Get(*b_, build_id).state() != v1::MAP_BUILD_STATE_RUNNING; }));
  const v1::MapBuild done = Get(*b_, build_id);
  ASSERT_EQ(done.state(), v1::MAP_BUILD_STATE_DONE) << done.error_message();
  EXPECT_EQ(done.attempt_count(), 2);
  EXPECT_EQ(done.version().version(), 1);
  EXPECT_EQ(done.drives_size(), 6);
  EXPECT_TRUE(Within(std::chrono::seconds(5), [&] {
    return std::filesystem::is_empty(folder_.path() / "shared" / "builds");
  }));
}

TEST_F(BuildReplicasTest, EachIsBuiltByOneAndAllSeeIt) {
  b_ = Start("b");
  std::vector<std::string> build_ids;
  build_ids.reserve(4);
  for (int i = 0; i < 4; ++i) build_ids.push_back(Begin(i % 2 == 0 ? *a_ : *b_, 1).build_id());
  for (const std::string& build_id : build_ids) {
    EXPECT_TRUE(Within(std::chrono::seconds(120),
                       [&] { return Get(*a_, build_id).state() != v1::MAP_BUILD_STATE_RUNNING; }));
    EXPECT_EQ(Get(*b_, build_id).state(), v1::MAP_BUILD_STATE_DONE);
    const std::string begun = "map build begun build=" + build_id;
    EXPECT_EQ(Count(a_->Log(), begun) + Count(b_->Log(), begun), 1U);
    EXPECT_EQ(Get(*b_, build_id).version().version(), 1) << "the same scans, the same file";
  }
}

TEST_F(BuildReplicasTest, OneCancelsWhatAnotherBuilds) {
  const std::string build_id = Begin(*a_, 6).build_id();
  b_ = Start("b");
  Call call;
  v1::CancelMapBuildRequest request;
  request.set_build_id(build_id);
  v1::CancelMapBuildResponse response;
  ASSERT_TRUE(b_->maps->CancelMapBuild(&call, request, &response).ok());
  EXPECT_TRUE(Within(std::chrono::seconds(30),
                     [&] { return Get(*b_, build_id).state() == v1::MAP_BUILD_STATE_CANCELLED; }));
  EXPECT_FALSE(Get(*b_, build_id).has_version());
}

}  // namespace
}  // namespace dcloc::server
