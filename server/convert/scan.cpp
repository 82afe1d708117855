#include "server/convert/scan.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/check.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"

namespace dcloc::server::convert {
namespace {

constexpr double kMaxCentreFrequency_hz = 1e13;
constexpr double kMaxSlope_hz_per_s = 1e18;

absl::StatusOr<double> BetaFromProto(const v1::Chirp& message, absl::string_view field) {
  absl::Status status = CheckBetween(absl::StrCat(field, ".centre_frequency_hz"),
                                     message.centre_frequency_hz(), 1.0, kMaxCentreFrequency_hz);
  status.Update(CheckBetween(absl::StrCat("the magnitude of ", field, ".slope_hz_per_s"),
                             std::abs(message.slope_hz_per_s()), 1.0, kMaxSlope_hz_per_s));
  if (!status.ok()) return status;
  return BetaFromChirp(message.centre_frequency_hz(), message.slope_hz_per_s());
}

void TakeSigmas(const v1::RadarModel& message, RadarModel* radar) {
  if (message.has_range_sigma_m()) radar->range_sigma_m = message.range_sigma_m();
  if (message.has_range_rate_sigma_mps()) {
    radar->range_rate_sigma_mps = message.range_rate_sigma_mps();
  }
  if (message.has_azimuth_sigma_rad()) radar->azimuth_sigma_rad = message.azimuth_sigma_rad();
  if (message.has_elevation_sigma_rad()) radar->elevation_sigma_rad = message.elevation_sigma_rad();
  if (message.has_beta_sigma_s()) radar->beta_sigma_s = message.beta_sigma_s();
  if (message.has_range_bias_sigma_m()) radar->range_bias_sigma_m = message.range_bias_sigma_m();
  if (message.has_time_offset_sigma_s()) {
    radar->time_offset_sigma_s = message.time_offset_sigma_s();
  }
  if (message.has_mount_yaw_sigma_rad()) {
    radar->mount_yaw_sigma_rad = message.mount_yaw_sigma_rad();
  }
}

absl::StatusOr<RadarModel> RadarFromProto(const v1::RadarModel& message, absl::string_view field) {
  if (absl::Status status = CheckId(absl::StrCat(field, ".radar_id"), message.radar_id());
      !status.ok()) {
    return status;
  }
  if (!message.has_t_vehicle_radar()) return Missing(absl::StrCat(field, ".t_vehicle_radar"));
  RadarModel radar;
  radar.id = message.radar_id();
  absl::StatusOr<Pose3> T_vehicle_radar =
      FromProto(message.t_vehicle_radar(), absl::StrCat(field, ".t_vehicle_radar"));
  if (!T_vehicle_radar.ok()) return T_vehicle_radar.status();
  radar.T_vehicle_radar = *T_vehicle_radar;
  if (message.has_beta_s()) radar.beta_s = message.beta_s();
  if (message.has_chirp()) {
    const absl::StatusOr<double> beta_s =
        BetaFromProto(message.chirp(), absl::StrCat(field, ".chirp"));
    if (!beta_s.ok()) return beta_s.status();
    radar.beta_s = *beta_s;
  }
  TakeSigmas(message, &radar);
  radar.has_elevation = message.has_elevation();
  radar.unambiguous_range_rate_mps = message.unambiguous_range_rate_mps();
  radar.range_bias_m = message.range_bias_m();
  radar.time_offset_s = message.time_offset_s();
  return radar;
}

absl::StatusOr<EgoVelocity> EgoVelocityFromProto(const v1::EgoVelocity& message) {
  EgoVelocity ego_velocity;
  ego_velocity.linear_mps = VectorFromProto(message.linear_mps());
  ego_velocity.angular_radps = VectorFromProto(message.angular_radps());
  if (!message.covariance().empty()) {
    absl::StatusOr<Matrix6d> covariance =
        CovarianceFromProto(message.covariance(), "ego_velocity.covariance");
    if (!covariance.ok()) return covariance.status();
    ego_velocity.covariance = *covariance;
  }
  return ego_velocity;
}

void TakeColumn(const google::protobuf::RepeatedField<float>& values, std::vector<float>* column) {
  column->assign(values.begin(), values.end());
}

void TakeColumns(const v1::Scan& message, Scan* scan) {
  TakeColumn(message.range_m(), &scan->range_m);
  TakeColumn(message.range_rate_mps(), &scan->range_rate_mps);
  TakeColumn(message.azimuth_rad(), &scan->azimuth_rad);
  TakeColumn(message.elevation_rad(), &scan->elevation_rad);
  TakeColumn(message.rcs_dbsm(), &scan->rcs_dbsm);
  TakeColumn(message.range_sigma_m(), &scan->range_sigma_m);
  TakeColumn(message.range_rate_sigma_mps(), &scan->range_rate_sigma_mps);
  TakeColumn(message.azimuth_sigma_rad(), &scan->azimuth_sigma_rad);
  TakeColumn(message.elevation_sigma_rad(), &scan->elevation_sigma_rad);
}

absl::Status TakeTicks(const v1::Scan& message, Scan* scan) {
  const v1::MotionTicks& motion = message.motion();
  const int count = motion.stamp_offset_ns_size();
  if (motion.speed_mps_size() != count || motion.yaw_rate_radps_size() != count) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "motion has %d stamps, %d speeds and %d yaw rates; it must have as many of each", count,
        motion.speed_mps_size(), motion.yaw_rate_radps_size()));
  }
  scan->ticks.clear();
  for (int i = 0; i < count; ++i) {
    scan->ticks.push_back({.after_scan = std::chrono::nanoseconds(motion.stamp_offset_ns(i)),
                           .speed_mps = motion.speed_mps(i),
                           .yaw_rate_radps = motion.yaw_rate_radps(i)});
  }
  return absl::OkStatus();
}

absl::Status CheckHeader(const v1::Scan& message, const Rig& rig) {
  constexpr long long kMax = std::numeric_limits<std::int64_t>::max();
  absl::Status status = CheckIntegerBetween("sequence_number", message.sequence_number(), 0, kMax);
  status.Update(CheckStamp("stamp_ns", message.stamp_ns()));
  if (status.ok() && rig.Find(message.radar_id()) == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrFormat("radar_id is %s; it must be one of the rig's", Quoted(message.radar_id())));
  }
  return status;
}

}  // namespace

absl::StatusOr<Rig> FromProto(const v1::Rig& message, absl::string_view field) {
  Rig rig;
  for (int i = 0; i < message.radars_size(); ++i) {
    absl::StatusOr<RadarModel> radar =
        RadarFromProto(message.radars(i), absl::StrCat(field, ".radars[", i, "]"));
    if (!radar.ok()) return radar.status();
    rig.radars.push_back(*std::move(radar));
  }
  absl::Status status = WithPrefix(absl::StrCat(field, ": "), Validate(rig));
  if (!status.ok()) return status;
  return rig;
}

absl::Status CheckStamp(absl::string_view field, std::int64_t stamp_ns) {
  return CheckIntegerBetween(field, stamp_ns, 1, kMaxStamp.time_since_epoch().count());
}

absl::Status FromProto(const v1::Scan& message, const Rig& rig, Scan* scan) {
  if (absl::Status status = CheckHeader(message, rig); !status.ok()) return status;
  scan->stamp = Stamp(std::chrono::nanoseconds(message.stamp_ns()));
  scan->radar_id = message.radar_id();
  TakeColumns(message, scan);
  if (absl::Status status = TakeTicks(message, scan); !status.ok()) return status;
  scan->ego_velocity.reset();
  if (message.has_ego_velocity()) {
    absl::StatusOr<EgoVelocity> ego_velocity = EgoVelocityFromProto(message.ego_velocity());
    if (!ego_velocity.ok()) return ego_velocity.status();
    scan->ego_velocity = *ego_velocity;
  }
  return Validate(*scan);
}

}  // namespace dcloc::server::convert
