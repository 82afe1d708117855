#include "core/localizer/localizer.h"

#include <utility>

#include "core/geometry/covariance.h"
#include "core/localizer/pipeline.h"

namespace dcloc {
namespace {

absl::Status Validate(const InitialPose& initial_pose) {
  const Pose3& pose = initial_pose.T_map_vehicle;
  if (!pose.translation_m.allFinite() || !(std::abs(pose.rotation.norm() - 1.0) < 1e-3)) {
    return absl::InvalidArgumentError(
        "initial_pose.T_map_vehicle must be finite with a rotation of norm 1");
  }
  if (!IsCovariance(initial_pose.covariance)) {
    return absl::InvalidArgumentError(
        "initial_pose.covariance must be finite, symmetric and positive semidefinite");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Localizer> Localizer::Create(std::shared_ptr<const RadarMap> map, Rig rig,
                                            const std::optional<InitialPose>& initial_pose,
                                            const LocalizerOptions& options) {
  absl::Status status = Validate(rig);
  status.Update(dcloc::Validate(options));
  if (initial_pose) status.Update(Validate(*initial_pose));
  if (!status.ok()) return status;
  // All six degrees of freedom need a map and a rig that both measure in space.
  if (map->info().has_elevation && rig.MeasuresElevation()) {
    return Localizer(
        std::make_unique<Pipeline<3>>(std::move(map), std::move(rig), initial_pose, options));
  }
  return Localizer(
      std::make_unique<Pipeline<2>>(std::move(map), std::move(rig), initial_pose, options));
}

Localizer::Localizer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

absl::StatusOr<Localization> Localizer::Localize(const Scan& scan, StageListener* listener) {
  return impl_->Localize(scan, listener);
}

bool Localizer::searching() const { return impl_->searching(); }

}  // namespace dcloc
