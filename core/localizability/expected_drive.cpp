#include "core/localizability/expected_drive.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "core/odometry/motion.h"
#include "core/radar/static_points.h"

namespace dcloc {
namespace {

constexpr double kPriorSigma_m = 0.3;
constexpr double kPriorSigma_rad = 0.02;
constexpr double kLead_m = 40.0;  // until sub-maps are full
constexpr std::size_t kMaxViewPoints = 400;
constexpr std::size_t kScansPerSnapshot = 50;
constexpr std::chrono::milliseconds kPause(100);  // between two drives, by the vehicle's clock

/// The rig of a vehicle whose radars are what they are described as.
Rig WithoutBiases(Rig rig) {
  for (RadarModel& radar : rig.radars) {
    radar.beta_s = 0.0;
    radar.range_bias_m = 0.0;
    radar.time_offset_s = 0.0;
    radar.unambiguous_range_rate_mps = 0.0;
  }
  return rig;
}

}  // namespace

std::span<const OptionField<ExpectedVehicle>> FieldsOf(const ExpectedVehicle& /*vehicle*/) {
  using V = ExpectedVehicle;
  static constexpr OptionField<V> kFields[] = {
      {"speed_mps", &V::speed_mps, 0.5, 60},
      {"scan_period_s", &V::scan_period_s, 0.02, 0.5},
      {"speed_sigma_mps", &V::speed_sigma_mps, 0, 5, "wheels are exact"},
      {"speed_scale_error", &V::speed_scale_error, 0, 0.1, "wheels have no such error"},
      {"yaw_rate_sigma_radps", &V::yaw_rate_sigma_radps, 0, 0.5, "the gyroscope is exact"},
      {"yaw_rate_bias_radps", &V::yaw_rate_bias_radps, 0, 0.1, "the gyroscope has none"},
      {"min_registration_ratio", &V::min_registration_ratio, 0.01, 20},
      {"min_odometry_ratio", &V::min_odometry_ratio, 0.0001, 20},
  };
  return kFields;
}

absl::Status Validate(const ExpectedVehicle& vehicle) {
  absl::Status status = ValidateFields(vehicle, FieldsOf(vehicle));
  status.Update(Within("scans", Validate(vehicle.scans)));
  status.Update(Within("rig", Validate(vehicle.rig)));
  if (status.ok() && vehicle.rig.radars.empty()) {
    return absl::InvalidArgumentError("rig has no radar; it must have one at least");
  }
  return status;
}

void AnswerSum::Add(const Localization& answer) {
  ++count;
  if (answer.state == LocalizationState::kTracking) ++tracking_count;
  if (answer.state == LocalizationState::kInitializing) return;
  ++posed_count;
  if (answer.observed[0]) ++observed_count;
  variance += answer.covariance.diagonal();
}

ExpectedDrive::ExpectedDrive(std::shared_ptr<const RadarMap> map, const Stretch& stretch,
                             const ExpectedVehicle& vehicle, std::vector<bool> is_tunnel,
                             std::uint64_t seed)
    : map_(std::move(map)),
      stretch_(stretch),
      vehicle_(vehicle),
      rig_(WithoutBiases(vehicle.rig)),
      path_(*map_, stretch, vehicle.speed_mps, kLead_m),
      scans_(map_, vehicle.scans, std::move(is_tunnel), seed),
      random_(seed),
      window_(LocalizerOptions{}.scans_per_submap),
      sums_(stretch.end - stretch.begin),
      views_(stretch.end - stretch.begin) {}

absl::Status ExpectedDrive::Run(const std::optional<LocalizerSnapshot>& learned) {
  absl::StatusOr<Localizer> localizer = Begin(learned);
  if (!localizer.ok()) return localizer.status();
  const double step_s = vehicle_.scan_period_s / static_cast<double>(rig_.radars.size());
  Pose3 T_map_before = path_.At(0.0).T_map_vehicle;
  for (std::size_t i = 0; static_cast<double>(i) * step_s < path_.duration_s(); ++i) {
    const double time_s = static_cast<double>(i) * step_s;
    const std::chrono::nanoseconds after(static_cast<std::int64_t>(std::llround(time_s * 1e9)));
    const std::size_t radar = i % rig_.radars.size();
    const PathPoint point = path_.At(time_s);
    const Scan scan = TakeScan(rig_.radars[radar], point, begin_ + after);
    const absl::StatusOr<Localization> answer = localizer->Localize(scan);
    if (!answer.ok()) return answer.status();
    if (time_s >= path_.lead_s()) sums_[point.nearest_keyframe - stretch_.begin].Add(*answer);
    KeepView(scan, radar, point, T_map_before.Inverse() * point.T_map_vehicle);
    T_map_before = point.T_map_vehicle;
    if (i % kScansPerSnapshot != 0) continue;
    if (std::optional<LocalizerSnapshot> snapshot = localizer->Snapshot()) learned_ = snapshot;
  }
  return absl::OkStatus();
}

/// At the first keyframe. Nobody doubts the prior.
absl::StatusOr<Localizer> ExpectedDrive::Begin(const std::optional<LocalizerSnapshot>& learned) {
  const PathPoint start = path_.At(0.0);
  begin_ = learned ? learned->stamp + kPause : Stamp(std::chrono::hours(24));
  InitialPose prior{.T_map_vehicle = start.T_map_vehicle, .covariance = Matrix6d::Zero()};
  prior.covariance.diagonal() << Eigen::Vector3d::Constant(kPriorSigma_m * kPriorSigma_m),
      Eigen::Vector3d::Constant(kPriorSigma_rad * kPriorSigma_rad);
  LocalizerOptions options;
  options.verify_prior = false;
  options.noise_scales.min_registration_ratio = vehicle_.min_registration_ratio;
  options.noise_scales.min_odometry_ratio = vehicle_.min_odometry_ratio;
  absl::StatusOr<Localizer> localizer = Localizer::Create(map_, rig_, prior, options);
  if (!localizer.ok() || !learned) return localizer;
  LocalizerSnapshot here = *learned;
  Vector6d since_then;
  since_then << start.velocity.linear_mps, start.velocity.angular_radps;
  since_then *= std::chrono::duration<double>(kPause).count();
  here.pose.T_map_vehicle = start.T_map_vehicle * Exp(Vector6d(-since_then));
  here.velocity.linear_mps = start.velocity.linear_mps;
  here.velocity.angular_radps = start.velocity.angular_radps;
  if (absl::Status status = localizer->Restore(here); !status.ok()) return status;
  return localizer;
}

Scan ExpectedDrive::TakeScan(const RadarModel& radar, const PathPoint& point, Stamp stamp) {
  Scan scan = scans_.At(radar, point.T_map_vehicle, point.velocity, stamp);
  scan.ego_velocity = point.velocity;
  scan.ego_velocity->linear_mps *= 1.0 + vehicle_.speed_scale_error;
  scan.ego_velocity->linear_mps.x() += vehicle_.speed_sigma_mps * normal_(random_);
  scan.ego_velocity->angular_radps.z() +=
      vehicle_.yaw_rate_bias_radps + vehicle_.yaw_rate_sigma_radps * normal_(random_);
  return scan;
}

/// The last one near a keyframe stays.
void ExpectedDrive::KeepView(const Scan& scan, std::size_t radar, const PathPoint& point,
                             const Pose3& T_before_now) {
  window_.Push(scan.stamp, static_cast<int>(radar),
               StaticPoints(scan, rig_.radars[radar], point.velocity, {}),
               {.T_from_to = T_before_now, .covariance = Matrix6d::Zero()});
  window_.Join(DriftCovariance::kLeftOut, kMaxViewPoints, submap_);
  PlaceView& view = views_[point.nearest_keyframe - stretch_.begin];
  view.T_map_vehicle = point.T_map_vehicle;
  view.points = submap_.points;
}

}  // namespace dcloc
