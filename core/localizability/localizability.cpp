#include "core/localizability/localizability.h"

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <utility>

#include "core/localizability/keyframe_path.h"
#include "core/localizer/localizer.h"
#include "core/odometry/motion.h"
#include "core/radar/static_points.h"
#include "core/submap/submap.h"

namespace dcloc {
namespace {

constexpr double kPriorSigma_m = 0.3;
constexpr double kPriorSigma_rad = 0.02;
constexpr std::size_t kMaxViewPoints = 400;
constexpr std::size_t kViewCount = 3;  // over some twenty metres

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

/// Answers near one keyframe.
struct AnswerSum {
  int count = 0;
  int tracking_count = 0;
  int posed_count = 0;
  int observed_count = 0;
  Vector6d variance = Vector6d::Zero();

  void Add(const Localization& answer) {
    ++count;
    if (answer.state == LocalizationState::kTracking) ++tracking_count;
    if (answer.state == LocalizationState::kInitializing) return;
    ++posed_count;
    if (answer.observed[0]) ++observed_count;
    variance += answer.covariance.diagonal();
  }

  void To(double min_observed_share, KeyframeLocalizability& result) const {
    if (posed_count == 0) return;
    const Vector6d sigma = (variance / posed_count).cwiseSqrt();
    result.is_known = true;
    result.along_sigma_m = sigma(0);
    result.across_sigma_m = sigma(1);
    result.heading_sigma_rad = sigma(5);
    result.tracking_share = static_cast<double>(tracking_count) / count;
    if (observed_count < min_observed_share * posed_count) result.is_tunnel = true;
  }
};

/// One vehicle on its way through one stretch.
class StretchDrive {
 public:
  StretchDrive(std::shared_ptr<const RadarMap> map, const Stretch& stretch,
               std::vector<bool> is_tunnel, const LocalizabilityOptions& options)
      : map_(std::move(map)),
        stretch_(stretch),
        options_(options),
        rig_(WithoutBiases(options.rig)),
        path_(*map_, stretch, options.speed_mps),
        scans_(map_, options.scans, std::move(is_tunnel), options.seed + stretch.begin),
        random_(options.seed + stretch.begin),
        window_(LocalizerOptions{}.scans_per_submap),
        sums_(stretch.end - stretch.begin),
        views_(stretch.end - stretch.begin) {}

  absl::Status Run() {
    const PathPoint start = path_.At(0.0);
    InitialPose prior{.T_map_vehicle = start.T_map_vehicle, .covariance = Matrix6d::Zero()};
    prior.covariance.diagonal() << Eigen::Vector3d::Constant(kPriorSigma_m * kPriorSigma_m),
        Eigen::Vector3d::Constant(kPriorSigma_rad * kPriorSigma_rad);
    LocalizerOptions localizer_options;
    localizer_options.verify_prior = false;  // nobody doubts it
    auto localizer = Localizer::Create(map_, rig_, prior, localizer_options);
    if (!localizer.ok()) return localizer.status();
    const double step_s = options_.scan_period_s / static_cast<double>(rig_.radars.size());
    Pose3 T_map_before = start.T_map_vehicle;
    for (std::size_t i = 0; static_cast<double>(i) * step_s < path_.duration_s(); ++i) {
      const double time_s = static_cast<double>(i) * step_s;
      const std::size_t radar = i % rig_.radars.size();
      const PathPoint point = path_.At(time_s);
      const Scan scan = TakeScan(rig_.radars[radar], point, time_s);
      const auto answer = localizer->Localize(scan);
      if (!answer.ok()) return answer.status();
      sums_[point.nearest_keyframe - stretch_.begin].Add(*answer);
      KeepView(scan, radar, point, T_map_before.Inverse() * point.T_map_vehicle);
      T_map_before = point.T_map_vehicle;
    }
    return absl::OkStatus();
  }

  void TellAccuracy(std::vector<KeyframeLocalizability>& result) const {
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      sums_[i].To(options_.min_observed_share, result[stretch_.begin + i]);
    }
  }

  /// Whether one of the keyframes is in a tunnel.
  bool TellLikeness(AliasFinder& aliases, std::vector<KeyframeLocalizability>& result) const {
    bool has_tunnel = false;
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const PlaceLikeness likeness = aliases.Find(ViewsFrom(i));
      KeyframeLocalizability& keyframe = result[stretch_.begin + i];
      keyframe.alias = likeness.alias;
      keyframe.is_tunnel = likeness.is_tunnel;
      has_tunnel = has_tunnel || likeness.is_tunnel;
    }
    return has_tunnel;
  }

 private:
  Scan TakeScan(const RadarModel& radar, const PathPoint& point, double time_s) {
    const auto after =
        std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(time_s * 1e9)));
    Scan scan = scans_.At(radar, point.T_map_vehicle, point.velocity,
                          Stamp(std::chrono::hours(24)) + after);
    scan.ego_velocity = point.velocity;
    scan.ego_velocity->linear_mps *= 1.0 + options_.speed_scale_error;
    scan.ego_velocity->linear_mps.x() += options_.speed_sigma_mps * normal_(random_);
    scan.ego_velocity->angular_radps.z() +=
        options_.yaw_rate_bias_radps + options_.yaw_rate_sigma_radps * normal_(random_);
    return scan;
  }

  /// What is seen from a keyframe on; at the end of the stretch, before it.
  std::vector<PlaceView> ViewsFrom(std::size_t index) const {
    std::vector<PlaceView> views = {views_[index]};
    for (std::size_t i = index + 1; i < views_.size() && views.size() < kViewCount; ++i) {
      views.push_back(views_[i]);
    }
    for (std::size_t i = index; i > 0 && views.size() < kViewCount; --i) {
      views.push_back(views_[i - 1]);
    }
    return views;
  }

  /// The last one near a keyframe stays.
  void KeepView(const Scan& scan, std::size_t radar, const PathPoint& point,
                const Pose3& T_before_now) {
    window_.Push(scan.stamp, static_cast<int>(radar),
                 StaticPoints(scan, rig_.radars[radar], point.velocity, {}),
                 {.T_from_to = T_before_now, .covariance = Matrix6d::Zero()});
    window_.Join(DriftCovariance::kLeftOut, kMaxViewPoints, submap_);
    PlaceView& view = views_[point.nearest_keyframe - stretch_.begin];
    view.T_map_vehicle = point.T_map_vehicle;
    view.points = submap_.points;
  }

  std::shared_ptr<const RadarMap> map_;
  Stretch stretch_;
  const LocalizabilityOptions& options_;
  Rig rig_;
  KeyframePath path_;
  ExpectedScans scans_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  SubmapWindow window_;
  LiveSubmap<2> submap_;
  std::vector<AnswerSum> sums_;   ///< by keyframe of the stretch
  std::vector<PlaceView> views_;  ///< likewise
};

std::vector<bool> TunnelsOf(const std::vector<KeyframeLocalizability>& keyframes) {
  std::vector<bool> is_tunnel;
  for (const KeyframeLocalizability& keyframe : keyframes) is_tunnel.push_back(keyframe.is_tunnel);
  return is_tunnel;
}

}  // namespace

Rig LocalizabilityOptions::DefaultRig() {
  RadarModel radar;
  radar.id = "front";
  radar.T_vehicle_radar.translation_m = {3.5, 0.0, 0.5};
  return {.radars = {radar}};
}

std::span<const OptionField<LocalizabilityOptions>> FieldsOf(
    const LocalizabilityOptions& /*options*/) {
  using O = LocalizabilityOptions;
  static constexpr OptionField<O> kFields[] = {
      {"speed_mps", &O::speed_mps, 0.5, 60},
      {"scan_period_s", &O::scan_period_s, 0.02, 0.5},
      {"speed_sigma_mps", &O::speed_sigma_mps, 0, 5, "wheels are exact"},
      {"speed_scale_error", &O::speed_scale_error, 0, 0.1, "wheels have no such error"},
      {"yaw_rate_bias_radps", &O::yaw_rate_bias_radps, 0, 0.1, "the gyroscope has none"},
      {"yaw_rate_sigma_radps", &O::yaw_rate_sigma_radps, 0, 0.5, "the gyroscope is exact"},
      {"min_observed_share", &O::min_observed_share, 0, 1, "nothing is a tunnel"},
  };
  return kFields;
}

absl::Status Validate(const LocalizabilityOptions& options) {
  absl::Status status = ValidateFields(options, FieldsOf(options));
  status.Update(Within("scans", Validate(options.scans)));
  status.Update(Within("aliases", Validate(options.aliases)));
  status.Update(Within("rig", Validate(options.rig)));
  if (status.ok() && options.rig.radars.empty()) {
    return absl::InvalidArgumentError("rig has no radar; it must have one at least");
  }
  return status;
}

KeyframeAccuracy AccuracyOf(const KeyframeLocalizability& keyframe) {
  KeyframeAccuracy accuracy{.sigmas = std::nullopt,
                            .is_tunnel = keyframe.is_tunnel,
                            .is_alias = keyframe.alias.has_value()};
  if (keyframe.is_known) {
    accuracy.sigmas = {.along_m = keyframe.along_sigma_m,
                       .across_m = keyframe.across_sigma_m,
                       .heading_rad = keyframe.heading_sigma_rad};
  }
  return accuracy;
}

absl::StatusOr<std::vector<KeyframeLocalizability>> ComputeLocalizability(
    const std::shared_ptr<const RadarMap>& map, const LocalizabilityOptions& options,
    const LocalizabilityProgress& progress) {
  if (absl::Status status = Validate(options); !status.ok()) return status;
  std::vector<KeyframeLocalizability> result(map->info().keyframe_count);
  AliasFinder aliases(map, options.aliases);
  for (const Stretch& stretch : StretchesOf(*map)) {
    StretchDrive drive(map, stretch, {}, options);
    if (absl::Status status = drive.Run(); !status.ok()) return status;
    if (drive.TellLikeness(aliases, result)) {
      // Once more, now that it is known where walls show nothing of the way.
      StretchDrive again(map, stretch, TunnelsOf(result), options);
      if (absl::Status status = again.Run(); !status.ok()) return status;
      again.TellAccuracy(result);
    } else {
      drive.TellAccuracy(result);
    }
    if (!progress(static_cast<double>(stretch.end) / static_cast<double>(result.size()))) {
      return absl::CancelledError("cancelled");
    }
  }
  return result;
}

}  // namespace dcloc
