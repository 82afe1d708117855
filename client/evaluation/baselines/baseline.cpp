#include "client/evaluation/baselines/baseline.h"

#include <cmath>
#include <utility>

#include "core/geometry/covariance.h"

namespace dcloc {

Pose3 Baseline::LocalFrame(const RadarMap& map, const Eigen::Vector3d& p_map,
                           const LocalizerOptions& options) {
  const auto nearest = map.NearestKeyframe(p_map, options.matcher.local_map_radius_m);
  return nearest ? map.keyframe(*nearest).T_map_keyframe : Pose3{};
}

Baseline::Baseline(std::shared_ptr<const RadarMap> map, const Pose3& T_map_local, Parts parts,
                   const LocalizerOptions& options)
    : map_(std::move(map)),
      options_(options),
      parts_(std::move(parts)),
      T_map_local_(T_map_local) {}

absl::StatusOr<Localization> Baseline::Localize(const Scan& scan, StageListener* listener) {
  const absl::StatusOr<Submap> submap = parts_.front_end.Add(scan, listener);
  if (!submap.ok()) return submap.status();
  quality_ = {.live_point_count = static_cast<int>(submap->points.size())};
  parts_.estimator->Advance(parts_.front_end.since_previous());
  if (parts_.front_end.RegistrationIsDue(scan.stamp, *submap)) {
    Register(*submap, scan.stamp, listener);
  }
  return Answer(scan.stamp);
}

void Baseline::Register(const Submap& submap, Stamp stamp, StageListener* listener) {
  if (listener != nullptr) listener->OnStageBegin(Stage::kRegistration);
  EnterLocalFrame();
  std::optional<PlanarFit> fit;
  if (!local_map_.empty()) {
    fit = parts_.registration->Register(
        InPlane(submap.points), local_map_, parts_.estimator->Now().T_local_vehicle,
        static_cast<std::uint64_t>(stamp.time_since_epoch().count()));
  }
  if (fit) quality_.inlier_count = fit->inlier_count;

  if (listener != nullptr) listener->OnStageBegin(Stage::kPoseGraph);
  const std::optional<double> distance = parts_.estimator->Correct(fit, submap.points);
  if (!distance) return;
  quality_.normalized_innovation_squared = *distance;
  quality_.is_accepted = true;
  last_accepted_ = stamp;
}

// The local map follows the vehicle, as in our own pipeline.
void Baseline::EnterLocalFrame() {
  const Eigen::Vector3d p_map =
      (T_map_local_ * Embed(parts_.estimator->Now().T_local_vehicle)).translation_m;
  const double radius_m = options_.matcher.local_map_radius_m;
  const auto nearest = map_->NearestKeyframe(p_map, radius_m);
  if (!nearest || nearest == keyframe_) return;
  keyframe_ = nearest;
  local_map_ = LocalMap<2>(*map_, p_map, radius_m);
  parts_.estimator->ChangeFrame(Flatten(local_map_.T_map_local().Inverse() * T_map_local_));
  T_map_local_ = local_map_.T_map_local();
}

Localization Baseline::Answer(Stamp stamp) const {
  const Estimator::Estimate now = parts_.estimator->Now();
  Localization answer{.stamp = stamp,
                      .T_map_vehicle = T_map_local_ * Embed(now.T_local_vehicle),
                      .quality = quality_};
  if (now.covariance) {
    answer.covariance = EmbedCovariance(*now.covariance, std::pow(options_.unobserved.z_m, 2),
                                        std::pow(options_.unobserved.tilt_rad, 2));
    for (const std::size_t observed : {0U, 1U, 5U}) answer.observed[observed] = true;
  }
  if (last_accepted_) {
    answer.state = stamp - *last_accepted_ <= options_.tracking.tracking_timeout
                       ? LocalizationState::kTracking
                       : LocalizationState::kDeadReckoning;
  }
  return answer;
}

}  // namespace dcloc
