#include "server/tickets/ticket_content.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/convert/learned_rig.h"
#include "server/tickets/ticket_content.pb.h"

namespace dcloc::server {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

constexpr int kPoseSize = 7;
constexpr int kTriangleSize = 21;
constexpr int kPairsSize = 6;
constexpr int kNoiseSize = 2 * (2 * kPairsSize + 2);

std::int64_t Nanoseconds(Stamp stamp) { return stamp.time_since_epoch().count(); }
Stamp StampOf(std::int64_t stamp_ns) { return Stamp(std::chrono::nanoseconds(stamp_ns)); }

absl::Status CheckSize(const char* name, int size, int wanted) {
  if (size == wanted) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("ticket: ", name, " has ", size, " numbers; it must have ", wanted));
}

void Write(const Pose3& pose, Numbers* numbers) {
  for (const double value : pose.translation_m) numbers->Add(value);
  for (const double value : pose.rotation.coeffs()) numbers->Add(value);
}

Pose3 ReadPose(const Numbers& numbers) {
  return {.translation_m = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]),
          .rotation = Eigen::Quaterniond(numbers[6], numbers[3], numbers[4], numbers[5])};
}

void WriteTriangle(const Matrix6d& covariance, Numbers* numbers) {
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) numbers->Add(covariance(row, column));
  }
}

Matrix6d ReadTriangle(const Numbers& numbers) {
  Matrix6d covariance;
  int i = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      covariance(row, column) = covariance(column, row) = numbers[i++];
    }
  }
  return covariance;
}

/// Calls `use` with each number of what was learned of the noise, always in the same order.
template <typename Knowledge, typename Use>
void ForEach(Knowledge& noise, Use use) {
  for (auto* part : {&noise.translation, &noise.rotation}) {
    for (auto* pairs : {&part->near, &part->far}) {
      use(pairs->error);
      use(pairs->registrations);
      use(pairs->odometry);
      use(pairs->count);
      use(pairs->prior_count);
      use(pairs->number);
    }
    use(part->odometry_ratio);
    use(part->registration_ratio);
  }
}

void Write(const TrackingSnapshot& tracking, sealed::Tracking* message) {
  message->set_mode(static_cast<int>(tracking.mode));
  message->set_verification(static_cast<int>(tracking.confirmation_requires));
  message->set_observability(static_cast<int>(tracking.observability));
  message->set_observability_changed_ns(Nanoseconds(tracking.observability_changed));
  message->set_last_accepted_ns(Nanoseconds(tracking.last_accepted));
  message->set_usual_interval_s(tracking.usual_interval_s);
  if (tracking.last_lost_to_outliers) {
    message->set_last_lost_to_outliers_ns(Nanoseconds(*tracking.last_lost_to_outliers));
  }
}

TrackingSnapshot Read(const sealed::Tracking& message) {
  TrackingSnapshot tracking{
      .mode = static_cast<TrackingMode>(message.mode()),
      .confirmation_requires = static_cast<ConfirmationRequirement>(message.verification()),
      .observability = static_cast<AlongTrackObservability>(message.observability()),
      .observability_changed = StampOf(message.observability_changed_ns()),
      .last_accepted = StampOf(message.last_accepted_ns()),
      .usual_interval_s = message.usual_interval_s(),
      .last_lost_to_outliers = std::nullopt};
  if (message.has_last_lost_to_outliers_ns()) {
    tracking.last_lost_to_outliers = StampOf(message.last_lost_to_outliers_ns());
  }
  return tracking;
}

void Write(const LocalizerSnapshot& snapshot, sealed::Snapshot* message) {
  message->set_stamp_ns(Nanoseconds(snapshot.stamp));
  Write(snapshot.pose.T_map_vehicle, message->mutable_pose());
  WriteTriangle(snapshot.pose.covariance, message->mutable_pose_covariance());
  for (const double value : snapshot.velocity.linear_mps) message->add_velocity(value);
  for (const double value : snapshot.velocity.angular_radps) message->add_velocity(value);
  WriteTriangle(snapshot.velocity.covariance.value_or(Matrix6d::Zero()),
                message->mutable_velocity_covariance());
  Write(snapshot.tracking, message->mutable_tracking());
  convert::ToProto(snapshot.known, message->mutable_known());
  ForEach(snapshot.noise, [message](double number) { message->add_noise(number); });
  message->set_reset_count(snapshot.resets.count);
  Write(snapshot.resets.T_before_after, message->mutable_last_jump());
  message->set_squared_innovation(snapshot.mean_nis);
  message->set_contradiction_m(snapshot.contradiction_m);
  message->set_factor_count(snapshot.registration_count);
  for (const std::chrono::nanoseconds ahead : snapshot.clocks_ahead) {
    message->add_clocks_ahead_ns(ahead.count());
  }
}

absl::StatusOr<LocalizerSnapshot> Read(const sealed::Snapshot& message) {
  absl::Status status = CheckSize("pose", message.pose_size(), kPoseSize);
  status.Update(CheckSize("pose_covariance", message.pose_covariance_size(), kTriangleSize));
  status.Update(CheckSize("velocity", message.velocity_size(), 6));
  status.Update(
      CheckSize("velocity_covariance", message.velocity_covariance_size(), kTriangleSize));
  status.Update(CheckSize("noise", message.noise_size(), kNoiseSize));
  status.Update(CheckSize("last_jump", message.last_jump_size(), kPoseSize));
  if (!status.ok()) return status;
  absl::StatusOr<RigKnowledge> known = convert::FromProto(message.known(), "ticket.known");
  if (!known.ok()) return known.status();
  const Numbers& velocity = message.velocity();
  LocalizerSnapshot snapshot{
      .stamp = StampOf(message.stamp_ns()),
      .pose = {.T_map_vehicle = ReadPose(message.pose()),
               .covariance = ReadTriangle(message.pose_covariance())},
      .velocity = {.linear_mps = {velocity[0], velocity[1], velocity[2]},
                   .angular_radps = {velocity[3], velocity[4], velocity[5]},
                   .covariance = ReadTriangle(message.velocity_covariance())},
      .tracking = Read(message.tracking()),
      .known = *std::move(known),
      .noise = {},
      .resets = {.count = message.reset_count(), .T_before_after = ReadPose(message.last_jump())},
      .mean_nis = message.squared_innovation(),
      .contradiction_m = message.contradiction_m(),
      .registration_count = message.factor_count(),
      .clocks_ahead = {}};
  ForEach(snapshot.noise,
          [&message, i = 0](double& number) mutable { number = message.noise(i++); });
  for (const std::int64_t ahead_ns : message.clocks_ahead_ns()) {
    snapshot.clocks_ahead.emplace_back(ahead_ns);
  }
  status = Validate(snapshot);
  if (!status.ok()) return status;
  return snapshot;
}

}  // namespace

absl::StatusOr<std::string> WriteTicketContent(const TicketContent& content, std::size_t max_size) {
  sealed::Content message;
  message.set_map_version(content.map_version);
  message.set_map_sha256(content.map_sha256);
  message.set_epoch(content.epoch);
  message.set_last_sequence_number(content.last_sequence_number);
  message.set_session_id(content.session_id);
  Write(content.snapshot, message.mutable_snapshot());
  if (message.ByteSizeLong() > max_size) {
    message.mutable_snapshot()->mutable_known()->clear_radars();
  }
  if (const std::size_t size = message.ByteSizeLong(); size > max_size) {
    return absl::ResourceExhaustedError(
        absl::StrCat("a ticket's content has ", size, " bytes; the limit is ", max_size));
  }
  return message.SerializeAsString();
}

absl::StatusOr<TicketContent> ReadTicketContent(absl::string_view bytes) {
  sealed::Content message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return absl::InvalidArgumentError("ticket: the content does not parse");
  }
  if (message.map_version() <= 0 || message.epoch() <= 0 || message.last_sequence_number() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("ticket: map_version is ", message.map_version(), ", epoch ", message.epoch(),
                     " and last_sequence_number ", message.last_sequence_number(),
                     "; the first two must lie above 0, and the last not below"));
  }
  absl::StatusOr<LocalizerSnapshot> snapshot = Read(message.snapshot());
  if (!snapshot.ok()) return snapshot.status();
  return TicketContent{.map_version = message.map_version(),
                       .map_sha256 = message.map_sha256(),
                       .epoch = message.epoch(),
                       .last_sequence_number = message.last_sequence_number(),
                       .session_id = message.session_id(),
                       .snapshot = *std::move(snapshot)};
}

}  // namespace dcloc::server
