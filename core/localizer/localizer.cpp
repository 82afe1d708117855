#include "core/localizer/localizer.h"

#include <utility>

#include "core/localizer/pipeline.h"
#include "core/registration/gicp_registration.h"

namespace dcloc {
namespace {

template <int Dim>
std::shared_ptr<const RegistrationMethod<Dim>> MethodOf(const RegistrationMethods& methods,
                                                        const LocalizerOptions& options) {
  if (methods.Of<Dim>() != nullptr) return methods.Of<Dim>();
  return std::make_shared<GicpRegistration<Dim>>(options.matcher.gicp);
}

}  // namespace

absl::StatusOr<Localizer> Localizer::Create(std::shared_ptr<const RadarMap> map, Rig rig,
                                            const std::optional<InitialPose>& initial_pose,
                                            const LocalizerOptions& options,
                                            const RegistrationMethods& methods) {
  if (map == nullptr) return absl::InvalidArgumentError("map must not be null");
  absl::Status status = Validate(rig);
  status.Update(Validate(options));
  if (initial_pose) status.Update(Validate(*initial_pose));
  if (!status.ok()) return status;
  // All six degrees of freedom need a map and a rig that both measure in space.
  if (map->info().has_elevation && rig.MeasuresElevation()) {
    return Localizer(std::make_unique<Pipeline<3>>(std::move(map), std::move(rig), initial_pose,
                                                   options, MethodOf<3>(methods, options)));
  }
  return Localizer(std::make_unique<Pipeline<2>>(std::move(map), std::move(rig), initial_pose,
                                                 options, MethodOf<2>(methods, options)));
}

Localizer::Localizer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Localizer::Localizer(Localizer&&) noexcept = default;
Localizer& Localizer::operator=(Localizer&&) noexcept = default;
Localizer::~Localizer() = default;

absl::StatusOr<Localization> Localizer::Localize(const Scan& scan, LocalizerWorkspace& workspace,
                                                 StageListener* listener) {
  return impl_->Localize(scan, workspace, listener);
}

absl::StatusOr<Localization> Localizer::Localize(const Scan& scan, StageListener* listener) {
  if (!own_workspace_) own_workspace_ = std::make_unique<LocalizerWorkspace>();
  return Localize(scan, *own_workspace_, listener);
}

bool Localizer::searching() const { return impl_->searching(); }

}  // namespace dcloc
