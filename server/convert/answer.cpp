#include "server/convert/answer.h"

#include <algorithm>
#include <string>

#include "server/convert/geometry.h"
#include "server/convert/learned_rig.h"

namespace dcloc::server::convert {
namespace {

void SetQuality(const LocalizationQuality& quality, v1::LocalizationQuality* message) {
  message->set_live_point_count(quality.live_point_count);
  message->set_inlier_count(quality.inlier_count);
  message->set_overlap(quality.overlap);
  message->set_residual_scale(quality.residual_scale);
  message->set_edge_distance(quality.normalized_innovation_squared);
  message->set_edge_valid(quality.is_accepted);
  message->set_beta_error_s(quality.beta.error_s);
  message->set_beta_error_sigma_s(quality.beta.sigma_s);
  message->set_beta_is_wrong(quality.beta.is_wrong);
}

void SetResets(const PoseResets& resets, v1::PoseResets* message) {
  message->set_count(resets.count);
  if (resets.count > 0) {
    ToProto(resets.T_before_after, message->mutable_last_jump());
  } else {
    message->clear_last_jump();
  }
}

v1::SourceFault FaultOf(SourceFault fault) {
  switch (fault) {
    case SourceFault::kNone:
      return v1::SOURCE_FAULT_NONE;
    case SourceFault::kSilent:
      return v1::SOURCE_FAULT_SILENT;
    case SourceFault::kStanding:
      return v1::SOURCE_FAULT_STANDING;
    case SourceFault::kFrozen:
      return v1::SOURCE_FAULT_FROZEN;
    case SourceFault::kSign:
      return v1::SOURCE_FAULT_SIGN;
    case SourceFault::kScale:
      return v1::SOURCE_FAULT_SCALE;
    case SourceFault::kBias:
      return v1::SOURCE_FAULT_BIAS;
    case SourceFault::kSlip:
      return v1::SOURCE_FAULT_SLIP;
    case SourceFault::kDoppler:
      return v1::SOURCE_FAULT_DOPPLER;
    case SourceFault::kMount:
      return v1::SOURCE_FAULT_MOUNT;
    case SourceFault::kMap:
      return v1::SOURCE_FAULT_MAP;
    case SourceFault::kClock:
      return v1::SOURCE_FAULT_CLOCK;
    case SourceFault::kDelay:
      return v1::SOURCE_FAULT_DELAY;
  }
  return v1::SOURCE_FAULT_UNSPECIFIED;
}

/// Of a SourceHealth or a RadarHealth.
template <typename Message>
void SetHealth(const SourceHealth& health, Message* message) {
  message->set_used(health.is_used);
  message->set_fault(FaultOf(health.fault));
}

void SetTimings(const ScanTimings& timings, v1::StageTimings* message) {
  message->set_queue_duration_ns(timings.queue.count());
  message->set_conversion_duration_ns(timings.conversion.count());
  message->set_compensation_duration_ns(timings.compensation.count());
  message->set_submap_duration_ns(timings.submap.count());
  message->set_registration_duration_ns(timings.registration.count());
  message->set_posegraph_duration_ns(timings.posegraph.count());
  message->set_total_duration_ns(timings.total.count());
  message->set_stamp_age_ns(timings.stamp_age.count());
}

void SetResult(const LocalizedScan& scan, std::int64_t sequence_number,
               v1::LocalizationResult* message) {
  message->set_sequence_number(sequence_number);
  message->set_map_version(scan.map_version);
  ToProto(scan.localization, message);
  if (scan.rig != nullptr) {
    ToProto(scan.localization.health, *scan.rig, message->mutable_health());
  } else {
    message->clear_health();
  }
  SetTimings(scan.timings, message->mutable_timings());
  if (scan.anchor) {
    ToProto(*scan.anchor, scan.localization.T_map_vehicle, message->mutable_geodetic_pose());
  } else {
    message->clear_geodetic_pose();
  }
}

void SetRejection(const absl::Status& status, std::int64_t sequence_number,
                  v1::ScanRejected* message) {
  message->set_sequence_number(sequence_number);
  message->set_code(static_cast<std::int32_t>(status.code()));
  message->set_message(std::string(status.message()));
}

}  // namespace

v1::LocalizationState ToProto(LocalizationState state) {
  switch (state) {
    case LocalizationState::kInitializing:
      return v1::LOCALIZATION_STATE_INITIALIZING;
    case LocalizationState::kTracking:
      return v1::LOCALIZATION_STATE_TRACKING;
    case LocalizationState::kDeadReckoning:
      return v1::LOCALIZATION_STATE_DEAD_RECKONING;
    case LocalizationState::kLost:
      return v1::LOCALIZATION_STATE_LOST;
  }
  return v1::LOCALIZATION_STATE_UNSPECIFIED;
}

void ToProto(const Localization& localization, v1::LocalizationResult* message) {
  message->set_stamp_ns(localization.stamp.time_since_epoch().count());
  message->set_state(ToProto(localization.state));
  ToProto(localization.T_map_vehicle, localization.covariance, message->mutable_pose());
  message->set_observed_dof_mask(static_cast<std::int32_t>(localization.observed.to_ulong()));
  if (localization.protection_level_m) {
    message->set_protection_level_m(*localization.protection_level_m);
  } else {
    message->clear_protection_level_m();
  }
  SetResets(localization.resets, message->mutable_resets());
  SetQuality(localization.quality, message->mutable_quality());
  if (localization.learned) {
    ToProto(*localization.learned, message->mutable_learned_rig());
  } else {
    message->clear_learned_rig();
  }
}

void ToProto(const Health& health, const Rig& rig, v1::Health* message) {
  SetHealth(health.wheel_speed, message->mutable_wheel_speed());
  SetHealth(health.yaw_rate, message->mutable_yaw_rate());
  const std::size_t count = std::min(health.radars.size(), rig.radars.size());
  while (message->radars_size() > static_cast<int>(count)) {
    message->mutable_radars()->RemoveLast();
  }
  while (message->radars_size() < static_cast<int>(count)) message->add_radars();
  for (std::size_t i = 0; i < count; ++i) {
    v1::RadarHealth* radar = message->mutable_radars(static_cast<int>(i));
    radar->set_radar_id(rig.radars[i].id);
    SetHealth(health.radars[i], radar);
  }
}

void ToProto(const ScanAnswer& answer, v1::LocalizeResponse* message) {
  if (answer.result.ok()) {
    SetResult(*answer.result, answer.sequence_number, message->mutable_result());
  } else {
    SetRejection(answer.result.status(), answer.sequence_number, message->mutable_rejected());
  }
  message->set_dropped_scan_count(answer.dropped_scan_count);
  message->set_from_memory(answer.from_memory);
  message->clear_ticket();
  if (!answer.ticket) return;
  message->mutable_ticket()->set_sealed(answer.ticket->sealed);
  message->mutable_ticket()->set_last_sequence_number(answer.ticket->last_sequence_number);
}

}  // namespace dcloc::server::convert
