#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/ros/diagnostics.h"
#include "client/ros/node_messages.h"
#include "client/ros/node_options.h"
#include "client/ros/topic_intake.h"
#include "client/ros/vehicle_link.h"

namespace dcloc::node {

/// A vehicle's node without its middleware: messages in, a session with the server, messages out.
///
/// The session opens once all radars have been heard and TF tells where they sit, or after
/// `radar_wait_s` with those of which that is known. Scans wait for it for a second, then they are
/// dropped and counted. All members may be called from any thread; none waits for the network.
class LocalizerNode {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Reads the files that `options` name. InvalidArgument, NotFound or DataLoss says what is wrong
  /// with an option or a file. `sink` outlives the node.
  static absl::StatusOr<std::unique_ptr<LocalizerNode>> Create(const NodeOptions& options,
                                                               NodeSink& sink);

  /// The topics to subscribe to, /tf_static among them. A message may be of any type: `Take` says
  /// where it is a wrong one.
  std::vector<std::string> topics() const;

  /// Takes a message of one of them that came at `now`.
  void Take(const rosbag::Message& message, Time now);

  /// Sends scans that have waited long enough; to be called some 100 times a second.
  void Advance(Time now);

  /// Publishes diagnostics; to be called about once a second.
  void Diagnose(Time now);

  /// Publishes the pose at `stamp` of the vehicle's clock, where it is known.
  void TellPose(Stamp stamp);

 private:
  LocalizerNode(const NodeOptions& options, BagMapping mapping, NodeSink& sink,
                std::shared_ptr<grpc::Channel> channel);

  void TakeFix(const rosbag::Message& message);
  void TakeInitialPose(const rosbag::Message& message);
  void GiveVelocity();
  void OpenOnceReady(Time now);
  void SendReady(Time now);
  void OnAnswer(const v1::LocalizeResponse& answer);
  void OnResult(const v1::LocalizationResult& result);
  void Warn(const std::string& text, Time now);

  const NodeOptions options_;
  NodeSink& sink_;

  std::mutex mutex_;
  TopicIntake intake_;
  Rig rig_;
  bool is_opened_ = false;
  std::optional<Time> first_radar_;
  std::optional<Stamp> newest_velocity_;
  std::int64_t sequence_number_ = 0;
  NodeState state_;
  std::optional<Time> warned_;
  std::int64_t unsaid_warning_count_ = 0;

  VehicleLink link_;  ///< last: its thread uses the others
};

}  // namespace dcloc::node
