#include "client/ros/localizer_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/client/datasets/temp_folder.h"
#include "tests/client/ros/messages.h"
#include "tests/client/sdk/fake_server.h"

namespace dcloc::node {
namespace {

using client::FakeServer;
using client::LocalizeServerStream;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr const char* kMapping = R"({"motion_topic": "/velocity", "radars": [
  {"id": "front", "topic": "/front", "range": "range", "azimuth": "azimuth",
   "range_rate": "range_rate"}]})";

/// Keeps what is published.
class Published final : public NodeSink {
 public:
  void Publish(const PoseMessage& pose) override { Keep(pose, poses_); }
  void Publish(const OdometryMessage& odometry) override { Keep(odometry, odometry_); }
  void Publish(const rosbag::Transform& transform) override { Keep(transform, transforms_); }
  void Publish(const std::vector<Diagnostic>& entries) override { Keep(entries, diagnostics_); }
  void Warn(const std::string& text) override { Keep(text, warnings_); }

  std::vector<PoseMessage> poses() const { return Copy(poses_); }
  std::vector<OdometryMessage> odometry() const { return Copy(odometry_); }
  std::vector<rosbag::Transform> transforms() const { return Copy(transforms_); }
  std::vector<std::vector<Diagnostic>> diagnostics() const { return Copy(diagnostics_); }
  std::vector<std::string> warnings() const { return Copy(warnings_); }

 private:
  template <typename T>
  void Keep(const T& item, std::vector<T>& items) {
    const std::lock_guard lock(mutex_);
    items.push_back(item);
  }
  template <typename T>
  std::vector<T> Copy(const std::vector<T>& items) const {
    const std::lock_guard lock(mutex_);
    return items;
  }

  mutable std::mutex mutex_;
  std::vector<PoseMessage> poses_;
  std::vector<OdometryMessage> odometry_;
  std::vector<rosbag::Transform> transforms_;
  std::vector<std::vector<Diagnostic>> diagnostics_;
  std::vector<std::string> warnings_;
};

/// Answers each scan: tracked, at x = 100 m.
grpc::Status AnswerWithPose(LocalizeServerStream& stream, v1::LocalizationState state) {
  v1::LocalizeRequest request;
  while (stream.Read(&request)) {
    v1::LocalizeResponse response;
    if (request.has_position_fix()) {
      response.mutable_position_fix_answer()->set_stamp_ns(request.position_fix().stamp_ns());
      response.mutable_position_fix_answer()->set_use(v1::FIX_USE_FUSED);
    } else {
      v1::LocalizationResult& result = *response.mutable_result();
      result.set_sequence_number(request.scan().sequence_number());
      result.set_stamp_ns(request.scan().stamp_ns());
      result.set_state(state);
      result.mutable_pose()->mutable_pose()->mutable_translation_m()->set_x(100.0);
      result.mutable_pose()->mutable_pose()->mutable_rotation()->set_w(1.0);
      for (int i = 0; i < 36; ++i) result.mutable_pose()->add_covariance(i % 7 == 0 ? 0.01 : 0.0);
    }
    stream.Write(response);
  }
  return grpc::Status::OK;
}

class LocalizerNodeTest : public ::testing::Test {
 protected:
  void Start(v1::LocalizationState state = v1::LOCALIZATION_STATE_TRACKING) {
    server_ = std::make_unique<FakeServer>(
        [this, state](grpc::ServerContext&, LocalizeServerStream& stream) {
          v1::LocalizeRequest request;
          stream.Read(&request);
          {
            const std::lock_guard lock(mutex_);
            opened_ = request.open();
          }
          v1::LocalizeResponse opened;
          opened.mutable_opened()->set_session_id("s");
          opened.mutable_opened()->set_takes_position_fixes(true);
          stream.Write(opened);
          return AnswerWithPose(stream, state);
        });
    folder_.Write("dcloc_bag.json", kMapping);
    auto node = LocalizerNode::Create(Options(), published_);
    ASSERT_TRUE(node.ok()) << node.status();
    node_ = *std::move(node);
  }

  NodeOptions Options() const {
    NodeOptions options;
    options.server = server_ ? server_->address() : "localhost:1";
    options.map = "town";
    options.mapping = (folder_.path() / "dcloc_bag.json").string();
    options.fix_topic = "/fix";
    return options;
  }

  void Take(const Sent& sent) { node_->Take(sent.message(), std::chrono::steady_clock::now()); }

  /// A radar with its mount, and wheels.
  void Hear() {
    Take(Mount());
    Take(OdometryAt(At(0), 5.0, 20.0));
    Take(CloudAt(At(0)));
  }

  bool Eventually(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      node_->Advance(std::chrono::steady_clock::now());
      std::this_thread::sleep_for(milliseconds(5));
    }
    return true;
  }

  Diagnostic State() {
    node_->Diagnose(std::chrono::steady_clock::now());
    return published_.diagnostics().back()[0];
  }

  std::string Value(const std::string& key) {
    const Diagnostic state = State();
    return std::ranges::find(state.values, key, [](const auto& v) { return v.first; })->second;
  }

  void DriveOn() {
    Hear();
    ASSERT_TRUE(Eventually([&] { return Value("connection") == "open"; }));
    for (int i = 1; i <= 3; ++i) {
      Take(OdometryAt(At(100 * i), 5.0 + 2.0 * i, 20.0));
      Take(CloudAt(At(100 * i)));
    }
  }

  TempFolder folder_;
  Published published_;
  std::mutex mutex_;
  v1::OpenSession opened_;
  std::unique_ptr<FakeServer> server_;
  std::unique_ptr<LocalizerNode> node_;
};

TEST_F(LocalizerNodeTest, AScanBecomesAPoseAndATransformOfTheOdometrysFrame) {
  Start();
  DriveOn();
  ASSERT_TRUE(Eventually([&] { return published_.transforms().size() >= 4; }));
  {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(opened_.map_name(), "town");
    ASSERT_EQ(opened_.rig().radars_size(), 1);
    EXPECT_EQ(opened_.rig().radars(0).t_vehicle_radar().translation_m().x(), 3.5);
  }
  const PoseMessage pose = published_.poses().back();
  EXPECT_EQ(pose.stamp, At(300));
  EXPECT_EQ(pose.frame, "map");
  EXPECT_EQ(pose.T_frame_vehicle.translation_m.x(), 100.0);
  EXPECT_EQ(pose.covariance[0], 0.01);
  const rosbag::Transform transform = published_.transforms().back();
  EXPECT_EQ(transform.parent, "map");
  EXPECT_EQ(transform.child, "odom");
  EXPECT_NEAR(transform.T_parent_child.translation_m.x(), 100.0 - 11.0, 1e-9);
}

TEST_F(LocalizerNodeTest, ThePresentIsToldByTheVehiclesOwnMotion) {
  Start();
  DriveOn();
  ASSERT_TRUE(Eventually([&] { return published_.poses().size() >= 4; }));
  node_->TellPose(At(350));
  const auto told = published_.odometry();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].child_frame, "base_link");
  EXPECT_EQ(told[0].pose.stamp, At(350));
  EXPECT_NEAR(told[0].velocity[0], 20.0, 1.0);
  node_->TellPose(At(100'000));
  EXPECT_EQ(published_.odometry().size(), 1U) << "nothing is told of a time without answers";
}

TEST_F(LocalizerNodeTest, APoseThatNobodyMayDriveByIsNotPublished) {
  Start(v1::LOCALIZATION_STATE_LOST);
  DriveOn();
  ASSERT_TRUE(Eventually([&] { return State().message == "lost"; }));
  EXPECT_TRUE(published_.poses().empty());
  EXPECT_TRUE(published_.transforms().empty());
}

TEST_F(LocalizerNodeTest, FixesGoToTheSession) {
  Start();
  Take(InitialPoseAt(At(0), 12.0));
  DriveOn();
  {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(opened_.initial_pose().pose().translation_m().x(), 12.0);
  }
  Take(SatelliteFixAt(At(310), true));
  Take(SatelliteFixAt(At(320), false));
  Take(InitialPoseAt(At(330), 13.0));
  EXPECT_TRUE(Eventually([&] { return Value("fixes_fused") == "2"; }));
  EXPECT_EQ(Value("fixes_sent"), "2");
  Take(InitialPoseAt(At(340), 13.0, "odom"));
  EXPECT_EQ(Value("fixes_refused"), "1");
}

TEST_F(LocalizerNodeTest, WhatIsWrongIsSaidOnceInAWhile) {
  Start();
  for (int i = 0; i < 50; ++i) Take(CloudAt(At(i), "/front", 3, "doppler"));
  ASSERT_EQ(published_.warnings().size(), 1U);
  EXPECT_THAT(published_.warnings()[0], HasSubstr("no field \"range_rate\""));
  node_->Diagnose(std::chrono::steady_clock::now());
  EXPECT_THAT(published_.diagnostics().back()[2].message, HasSubstr("no field \"range_rate\""));
}

TEST_F(LocalizerNodeTest, WithoutAServerScansAreDroppedAndCounted) {
  folder_.Write("dcloc_bag.json", kMapping);
  node_ = *LocalizerNode::Create(Options(), published_);
  Hear();
  EXPECT_TRUE(Eventually([&] {
    Take(CloudAt(At(10)));
    const Diagnostic state = State();
    return state.level == Diagnostic::Level::kError &&
           std::ranges::find(state.values, std::pair<std::string, std::string>(
                                               "scans_dropped", "0")) == state.values.end();
  }));
  EXPECT_THAT(published_.warnings().at(0), HasSubstr("no session is open"));
}

TEST_F(LocalizerNodeTest, FilesThatAreNotThereAreNamed) {
  NodeOptions options = Options();
  const auto missing = LocalizerNode::Create(options, published_).status();
  EXPECT_THAT(std::string(missing.message()), HasSubstr("dcloc_bag.json"));
  folder_.Write("dcloc_bag.json", kMapping);
  options.rig = (folder_.path() / "no_rig.json").string();
  EXPECT_THAT(std::string(LocalizerNode::Create(options, published_).status().message()),
              HasSubstr("no_rig.json"));
  options.rig.clear();
  options.token_file = (folder_.path() / "no_token").string();
  EXPECT_THAT(std::string(LocalizerNode::Create(options, published_).status().message()),
              HasSubstr("no_token"));
}

}  // namespace
}  // namespace dcloc::node
