#include "client/ros/localizer_node.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/cli/remote/wire.h"
#include "client/datasets/rig_file.h"
#include "client/ros/fix_messages.h"
#include "client/rosbag/message_reader.h"
#include "client/rosbag/message_types.h"
#include "client/sdk/channel.h"

namespace dcloc::node {
namespace {

constexpr std::chrono::milliseconds kRetryAfter{1000};
constexpr std::chrono::milliseconds kOpenTimeout{3000};
/// Scans wait so long for a session to open; older ones are worth little.
constexpr std::chrono::seconds kMaxWaitForSession{1};
/// A log line for each message of a wrong type would hide everything else.
constexpr std::chrono::seconds kBetweenWarnings{5};

client::SessionOptions SessionOptionsOf(const NodeOptions& options) {
  client::SessionOptions session;
  session.open_timeout = kOpenTimeout;
  session.max_queued_scan_count = static_cast<std::size_t>(options.max_queued_scan_count);
  session.reconnect->max_backoff = std::chrono::seconds(2);
  session.reconnect->give_up_after =
      std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * options.reconnect_give_up_s));
  return session;
}

Stamp StampOf(std::int64_t stamp_ns) { return Stamp(std::chrono::nanoseconds(stamp_ns)); }

Pose3 PoseOf(const v1::Pose& pose) {
  const v1::Vector3& t = pose.translation_m();
  const v1::Quaternion& q = pose.rotation();
  return {{t.x(), t.y(), t.z()}, Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z())};
}

Pose3 PoseOf(const client::RigidPose& T) {
  const auto& [w, x, y, z] = T.rotation_wxyz;
  return {Eigen::Vector3d(T.translation_m.data()), Eigen::Quaterniond(w, x, y, z)};
}

/// A pose that others may drive by.
bool IsUsable(v1::LocalizationState state) {
  return state == v1::LOCALIZATION_STATE_TRACKING || state == v1::LOCALIZATION_STATE_DEAD_RECKONING;
}

v1::EgoVelocity ToProto(const EgoVelocity& velocity) {
  const Scan scan{.ego_velocity = velocity};
  return cli::ToProto(scan, 0).ego_velocity();
}

}  // namespace

absl::StatusOr<std::unique_ptr<LocalizerNode>> LocalizerNode::Create(const NodeOptions& options,
                                                                     NodeSink& sink) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  absl::StatusOr<BagMapping> mapping = ReadBagMapping(options.mapping);
  if (!mapping.ok()) return mapping.status();
  if (!options.rig.empty()) {
    Rig known;
    for (const RadarMapping& radar : mapping->radars) {
      known.radars.emplace_back().id = radar.id;
    }
    if (absl::Status status = ApplyRigFile(options.rig, known); !status.ok()) return status;
  }
  const auto channel = client::MakeChannel({.server = options.server,
                                            .tls_ca = options.tls_ca,
                                            .tls_cert = options.tls_cert,
                                            .tls_key = options.tls_key,
                                            .token_file = options.token_file});
  if (!channel.ok()) return channel.status();
  return std::unique_ptr<LocalizerNode>(
      new LocalizerNode(options, *std::move(mapping), sink, *channel));
}

LocalizerNode::LocalizerNode(const NodeOptions& options, BagMapping mapping, NodeSink& sink,
                             std::shared_ptr<grpc::Channel> channel)
    : options_(options),
      sink_(sink),
      intake_(
          std::move(mapping),
          std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * options.max_velocity_wait_s))),
      link_(std::move(channel), SessionOptionsOf(options), kRetryAfter,
            [this](const v1::LocalizeResponse& answer) { OnAnswer(answer); }) {}

std::vector<std::string> LocalizerNode::topics() const {
  std::vector<std::string> topics = {"/tf_static"};
  const BagMapping& mapping = intake_.mapping();
  for (const RadarMapping& radar : mapping.radars) topics.push_back(radar.topic);
  for (const std::string& topic :
       {mapping.motion_topic, mapping.imu_topic, options_.fix_topic, options_.initial_pose_topic}) {
    if (!topic.empty()) topics.push_back(topic);
  }
  return topics;
}

void LocalizerNode::Take(const rosbag::Message& message, Time now) {
  const std::lock_guard lock(mutex_);
  const std::string& topic = message.connection.topic;
  if (topic == options_.fix_topic) return TakeFix(message);
  if (topic == options_.initial_pose_topic) return TakeInitialPose(message);
  if (const absl::Status status = intake_.Take(message, now); !status.ok()) {
    return Warn(std::string(status.message()), now);
  }
  if (!first_radar_ && topic != "/tf_static") first_radar_ = now;
  GiveVelocity();
  SendReady(now);
}

/// For poses between answers.
void LocalizerNode::GiveVelocity() {
  const std::optional<Stamp> newest = intake_.newest_motion();
  if (!newest || newest == newest_velocity_) return;
  newest_velocity_ = newest;
  if (!link_.is_open()) return;
  if (const std::optional<EgoVelocity> velocity = intake_.NewestVelocity()) {
    link_.AddVelocity(newest->time_since_epoch().count(), ToProto(*velocity));
  }
}

void LocalizerNode::TakeFix(const rosbag::Message& message) {
  absl::Status status = rosbag::CheckType(message.connection);
  if (status.ok() && message.connection.type != rosbag::kNavSatFix.name) {
    status = absl::InvalidArgumentError(absl::StrCat("topic ", message.connection.topic,
                                                     " is of type ", message.connection.type,
                                                     "; it must be ", rosbag::kNavSatFix.name));
  }
  if (status.ok()) {
    const absl::StatusOr<rosbag::SatelliteFix> parsed = rosbag::ParseSatelliteFix(message.data);
    status = parsed.status();
    if (parsed.ok() && !parsed->has_fix) return;  // as in a tunnel
    const auto fix = parsed.ok() ? FixOf(*parsed, options_.fix_sigma_m)
                                 : absl::StatusOr<v1::PositionFix>(parsed.status());
    if (fix.ok()) status = link_.SendFix(*fix);
  }
  ++(status.ok() ? state_.counts.fixes_sent : state_.counts.fixes_refused);
  if (!status.ok()) Warn(std::string(status.message()), std::chrono::steady_clock::now());
}

void LocalizerNode::TakeInitialPose(const rosbag::Message& message) {
  absl::Status status = rosbag::CheckType(message.connection);
  if (status.ok() && message.connection.type != rosbag::kPoseWithCovarianceStamped.name) {
    status = absl::InvalidArgumentError(
        absl::StrCat("topic ", message.connection.topic, " is of type ", message.connection.type,
                     "; it must be ", rosbag::kPoseWithCovarianceStamped.name));
  }
  absl::StatusOr<v1::PoseWithCovariance> pose = status;
  std::int64_t stamp_ns = 0;
  if (status.ok()) {
    const auto parsed = rosbag::ParseMotion(message.connection.type, message.data);
    pose = parsed.ok() ? node::PoseOf(*parsed, intake_.mapping().map_frame)
                       : absl::StatusOr<v1::PoseWithCovariance>(parsed.status());
    if (parsed.ok()) stamp_ns = parsed->header.stamp.time_since_epoch().count();
  }
  if (!pose.ok()) {
    ++state_.counts.fixes_refused;
    return Warn(absl::StrCat("topic ", message.connection.topic, ": ", pose.status().message()),
                std::chrono::steady_clock::now());
  }
  if (!link_.is_open()) return link_.SetInitialPose(*pose);
  v1::PositionFix fix;
  // Tools that know no time leave it 0.
  fix.set_stamp_ns(stamp_ns != 0 || !state_.newest ? stamp_ns : state_.newest->stamp_ns());
  *fix.mutable_map_pose() = *std::move(pose);
  status = link_.SendFix(std::move(fix));
  ++(status.ok() ? state_.counts.fixes_sent : state_.counts.fixes_refused);
}

void LocalizerNode::Advance(Time now) {
  const std::lock_guard lock(mutex_);
  OpenOnceReady(now);
  SendReady(now);
}

void LocalizerNode::OpenOnceReady(Time now) {
  if (is_opened_ || !first_radar_) return;
  const absl::Status status = intake_.DescribeRadars(rig_);
  const bool waits =
      !status.ok() && now - *first_radar_ < std::chrono::duration<double>(options_.radar_wait_s);
  if (waits || rig_.radars.empty()) {
    if (!waits) Warn(std::string(status.message()), now);
    return;
  }
  if (!status.ok()) Warn(absl::StrCat(status.message(), "; going on without it"), now);
  if (!options_.rig.empty()) {
    if (const absl::Status applied = ApplyRigFile(options_.rig, rig_); !applied.ok()) {
      return Warn(std::string(applied.message()), now);
    }
  }
  v1::OpenSession open;
  open.set_vehicle_id(options_.vehicle);
  open.set_map_name(options_.map);
  *open.mutable_rig() = cli::ToProto(rig_);
  is_opened_ = true;
  link_.Open(std::move(open));
}

void LocalizerNode::SendReady(Time now) {
  if (!link_.is_open()) {
    const std::int64_t dropped = intake_.dropped_count();
    intake_.DropWaitingSince(now - kMaxWaitForSession);
    if (intake_.dropped_count() == dropped) return;
    return Warn(absl::StrCat("no session is open, and scans are dropped, ", intake_.dropped_count(),
                             " so far"),
                now);
  }
  for (const Scan& scan : intake_.TakeReady(rig_, now)) {
    const absl::Status status = link_.Send(cli::ToProto(scan, sequence_number_));
    if (status.ok()) {
      ++sequence_number_;
      ++state_.counts.sent;
    } else {
      ++state_.counts.dropped;
      Warn(absl::StrCat("a scan of ", scan.radar_id, " is dropped, the ", state_.counts.dropped,
                        ". so far: ", status.message()),
           now);
    }
  }
}

void LocalizerNode::OnAnswer(const v1::LocalizeResponse& answer) {
  const std::lock_guard lock(mutex_);
  if (answer.has_result()) return OnResult(answer.result());
  if (answer.has_rejected()) {
    ++state_.counts.rejected;
    state_.last_rejection = answer.rejected().message();
    return Warn(absl::StrCat("the server rejected a scan: ", answer.rejected().message()),
                std::chrono::steady_clock::now());
  }
  if (!answer.has_position_fix_answer()) return;
  const v1::FixUse use = answer.position_fix_answer().use();
  const bool is_fused = use == v1::FIX_USE_FUSED || use == v1::FIX_USE_GUIDES_SEARCH;
  ++(is_fused ? state_.counts.fixes_fused : state_.counts.fixes_refused);
}

void LocalizerNode::OnResult(const v1::LocalizationResult& result) {
  ++state_.counts.answered;
  state_.newest = result;
  state_.newest_at = std::chrono::steady_clock::now();
  if (!IsUsable(result.state()) || result.pose().covariance_size() != 36) return;
  const BagMapping& mapping = intake_.mapping();
  PoseMessage pose{.stamp = StampOf(result.stamp_ns()),
                   .frame = mapping.map_frame,
                   .T_frame_vehicle = PoseOf(result.pose().pose())};
  std::ranges::copy(result.pose().covariance(), pose.covariance.begin());
  sink_.Publish(pose);
  if (!options_.publish_tf) return;
  const std::optional<Pose3> T_odom_vehicle = intake_.OdometryAt(pose.stamp);
  rosbag::Transform transform{.stamp = pose.stamp, .parent = mapping.map_frame};
  transform.child = T_odom_vehicle ? options_.odom_frame : mapping.vehicle_frame;
  transform.T_parent_child =
      T_odom_vehicle ? pose.T_frame_vehicle * T_odom_vehicle->Inverse() : pose.T_frame_vehicle;
  sink_.Publish(transform);
}

void LocalizerNode::TellPose(Stamp stamp) {
  const auto estimate = link_.SmoothPoseAt(stamp.time_since_epoch().count());
  if (!estimate.ok() || !IsUsable(estimate->state)) return;
  const std::lock_guard lock(mutex_);
  OdometryMessage odometry{.pose = {.stamp = stamp,
                                    .frame = intake_.mapping().map_frame,
                                    .T_frame_vehicle = PoseOf(estimate->T_map_vehicle),
                                    .covariance = estimate->covariance},
                           .child_frame = intake_.mapping().vehicle_frame,
                           .velocity = estimate->velocity};
  sink_.Publish(odometry);
}

void LocalizerNode::Diagnose(Time now) {
  const std::lock_guard lock(mutex_);
  state_.link = link_.status();
  state_.counts.dropped_before = intake_.dropped_count();
  state_.counts.clock_jumps = intake_.clock_jump_count();
  sink_.Publish(DiagnosticsOf(state_, intake_.topics(), now));
}

void LocalizerNode::Warn(const std::string& text, Time now) {
  if (warned_ && now - *warned_ < kBetweenWarnings) {
    ++unsaid_warning_count_;
    return;
  }
  sink_.Warn(unsaid_warning_count_ == 0
                 ? text
                 : absl::StrCat(text, " (and ", unsaid_warning_count_, " more warnings since)"));
  warned_ = now;
  unsaid_warning_count_ = 0;
}

}  // namespace dcloc::node
