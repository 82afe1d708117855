#include "client/ros/topic_intake.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "client/datasets/rosbag.h"

namespace dcloc::node {
namespace {

/// A stamp so far before the newest one says that the clock was set back.
constexpr std::chrono::nanoseconds kSetBack = std::chrono::seconds(1);
/// Motion is kept for answers, which come late when a connection breaks.
constexpr std::chrono::nanoseconds kKept = std::chrono::seconds(2);
constexpr std::size_t kMaxWaiting = 512;

/// Forgets what is old, and all that is there once the newest says that the clock was set back.
/// Returns whether it was.
template <typename Message>
bool Trim(std::vector<Message>& messages) {
  if (messages.size() < 2) return false;
  const Stamp newest = messages.back().header.stamp;
  if (newest < messages[messages.size() - 2].header.stamp - kSetBack) {
    messages.erase(messages.begin(), messages.end() - 1);
    return true;
  }
  std::erase_if(messages,
                [&](const Message& message) { return message.header.stamp < newest - kKept; });
  return false;
}

/// Moves the newest to where its stamp belongs.
template <typename Message>
void Settle(std::vector<Message>& messages) {
  for (std::size_t i = messages.size(); i > 1; --i) {
    if (messages[i - 2].header.stamp <= messages[i - 1].header.stamp) return;
    std::swap(messages[i - 2], messages[i - 1]);
  }
}

}  // namespace

TopicIntake::TopicIntake(BagMapping mapping, std::chrono::nanoseconds max_wait)
    : mapping_(std::move(mapping)), max_wait_(max_wait), collector_(mapping_, contents_) {
  for (const RadarMapping& radar : mapping_.radars) topics_[radar.topic];
  for (const std::string& topic : {mapping_.motion_topic, mapping_.imu_topic}) {
    if (!topic.empty()) topics_[topic];
  }
}

absl::Status TopicIntake::Take(const rosbag::Message& message, Time now) {
  TopicState& topic = topics_[message.connection.topic];
  topic.newest = now;
  ++topic.message_count;
  const absl::Status status = collector_.Take(message);
  topic.error = std::string(status.message());
  if (!status.ok()) {
    ++topic.error_count;
    return status;
  }
  if (contents_.scans.empty()) motion_.reset();
  AfterJumps();
  Settle(contents_.motions);
  Settle(contents_.turn_rates);
  contents_.references.clear();
  for (Scan& scan : contents_.scans) {
    if (newest_scan_ && scan.stamp < *newest_scan_ - kSetBack) {
      ++clock_jump_count_;
      dropped_count_ += static_cast<std::int64_t>(waiting_.size());
      waiting_.clear();
      newest_scan_.reset();
    }
    newest_scan_ = std::max(newest_scan_.value_or(scan.stamp), scan.stamp);
    waiting_.push_back({std::move(scan), now});
  }
  contents_.scans.clear();
  if (waiting_.size() > kMaxWaiting) {
    ++dropped_count_;
    waiting_.erase(waiting_.begin());
  }
  return status;
}

void TopicIntake::AfterJumps() {
  for (const bool jumped : {Trim(contents_.motions), Trim(contents_.turn_rates)}) {
    if (jumped) ++clock_jump_count_;
  }
}

/// Whether what was reported around the stamp has come.
bool TopicIntake::IsKnown(Stamp stamp) const {
  const auto reaches = [stamp](const auto& messages, const std::string& topic) {
    return topic.empty() || (!messages.empty() && messages.back().header.stamp >= stamp);
  };
  return reaches(contents_.motions, mapping_.motion_topic) &&
         reaches(contents_.turn_rates, mapping_.imu_topic);
}

const BagMotion* TopicIntake::Motion() {
  if (!motion_) {
    absl::StatusOr<BagMotion> motion = BagMotion::Create(contents_, mapping_);
    if (!motion.ok()) {
      topics_[mapping_.motion_topic].error = std::string(motion.status().message());
      return nullptr;
    }
    motion_ = *std::move(motion);
  }
  return &*motion_;
}

std::vector<Scan> TopicIntake::TakeReady(const Rig& rig, Time now) {
  std::ranges::sort(waiting_, {}, [](const Waiting& waiting) {
    return std::tie(waiting.scan.stamp, waiting.scan.radar_id);
  });
  std::vector<Scan> ready;
  std::size_t count = 0;
  for (; count < waiting_.size(); ++count) {
    Waiting& next = waiting_[count];
    if (!IsKnown(next.scan.stamp) && now - next.since < max_wait_) break;
    const RadarModel* const radar = rig.Find(next.scan.radar_id);
    const auto mapping = std::ranges::find(mapping_.radars, next.scan.radar_id, &RadarMapping::id);
    if (const BagMotion* motion = Motion(); motion != nullptr) {
      next.scan.ego_velocity = motion->VelocityAt(next.scan.stamp);
    }
    if (radar == nullptr ||
        (mapping->range_rate_is_compensated && !Uncompensate(*radar, next.scan).ok())) {
      ++dropped_count_;
      continue;
    }
    ready.push_back(std::move(next.scan));
  }
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  return ready;
}

void TopicIntake::DropWaitingSince(Time before) {
  dropped_count_ += static_cast<std::int64_t>(
      std::erase_if(waiting_, [&](const Waiting& waiting) { return waiting.since < before; }));
}

absl::Status TopicIntake::DescribeRadars(Rig& rig) const {
  absl::Status first;
  rig.radars.clear();
  for (const RadarMapping& radar : mapping_.radars) {
    absl::StatusOr<RadarModel> model = RadarOf(radar, contents_, mapping_.vehicle_frame);
    if (model.ok()) rig.radars.push_back(*std::move(model));
    first.Update(model.status());
  }
  return first;
}

std::optional<Pose3> TopicIntake::OdometryAt(Stamp stamp) {
  const BagMotion* const motion = Motion();
  return motion == nullptr ? std::nullopt : motion->PoseAt(stamp);
}

std::optional<Stamp> TopicIntake::newest_motion() const {
  if (contents_.motions.empty()) return std::nullopt;
  return contents_.motions.back().header.stamp;
}

std::optional<EgoVelocity> TopicIntake::NewestVelocity() {
  const BagMotion* const motion = Motion();
  if (motion == nullptr || contents_.motions.empty()) return std::nullopt;
  return motion->VelocityAt(contents_.motions.back().header.stamp);
}

}  // namespace dcloc::node
