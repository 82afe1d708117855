#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/datasets/bag_contents.h"
#include "client/datasets/bag_mapping.h"
#include "client/datasets/bag_motion.h"
#include "client/rosbag/bag_reader.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc::node {

/// What has come on a topic.
struct TopicState {
  std::int64_t message_count = 0;
  std::int64_t error_count = 0;
  std::string error;  ///< of the newest message, empty where it could be used
  std::optional<std::chrono::steady_clock::time_point> newest;
};

/// Makes scans with ego-velocities of a vehicle's messages as they come, by the mapping that bags
/// are read by. A scan waits until the velocity at its stamp is known, so that it is the one that
/// `ReadRosbagDrive` finds in a bag of the same messages. Not thread-safe.
class TopicIntake {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Scans wait at most `max_wait`. `mapping` is valid.
  TopicIntake(BagMapping mapping, std::chrono::nanoseconds max_wait);
  TopicIntake(const TopicIntake&) = delete;
  TopicIntake& operator=(const TopicIntake&) = delete;

  /// Takes a message of a topic that the mapping names, or of TF's, that came at `now`. Errors as
  /// of BagCollector; the message is then left out and counted.
  absl::Status Take(const rosbag::Message& message, Time now);

  /// The scans that wait no longer, by stamp and radar. Those of radars that `rig` has not are left
  /// out and counted, as are those whose range rates are compensated by a velocity that is missing.
  std::vector<Scan> TakeReady(const Rig& rig, Time now);

  /// Drops the scans that came before `before`, and counts them.
  void DropWaitingSince(Time before);

  /// Puts the radars into `rig` that can be described by now. The status is that of the first one
  /// that cannot (RadarOf).
  absl::Status DescribeRadars(Rig& rig) const;

  /// The vehicle by its own odometry, where that tells poses.
  std::optional<Pose3> OdometryAt(Stamp stamp);
  /// The newest velocity, and its stamp.
  std::optional<EgoVelocity> NewestVelocity();
  std::optional<Stamp> newest_motion() const;

  const BagMapping& mapping() const { return mapping_; }
  const std::map<std::string, TopicState>& topics() const { return topics_; }
  std::int64_t dropped_count() const { return dropped_count_; }
  std::int64_t clock_jump_count() const { return clock_jump_count_; }

 private:
  struct Waiting {
    Scan scan;
    Time since;
  };

  void AfterJumps();
  bool IsKnown(Stamp stamp) const;
  const BagMotion* Motion();

  const BagMapping mapping_;
  const std::chrono::nanoseconds max_wait_;
  BagContents contents_;
  BagCollector collector_;
  std::vector<Waiting> waiting_;
  std::optional<Stamp> newest_scan_;
  std::optional<BagMotion> motion_;  ///< of the contents; empty once they have changed
  std::map<std::string, TopicState> topics_;
  std::int64_t dropped_count_ = 0;
  std::int64_t clock_jump_count_ = 0;
};

}  // namespace dcloc::node
