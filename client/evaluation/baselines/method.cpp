#include "client/evaluation/baselines/method.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "client/evaluation/baselines/baseline.h"
#include "client/evaluation/baselines/descriptor_registration.h"
#include "client/evaluation/baselines/method_in_localizer.h"
#include "client/evaluation/baselines/pcl_registration.h"
#include "core/geometry/covariance.h"

namespace dcloc {
namespace {

class Ours final : public Method {
 public:
  explicit Ours(Localizer localizer) : localizer_(std::move(localizer)) {}

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) override {
    return localizer_.Localize(scan, listener);
  }

 private:
  Localizer localizer_;
};

std::unique_ptr<PlanarRegistration> MakeRegistration(MethodKind kind,
                                                     const LocalizerOptions& options) {
  switch (kind) {
    case MethodKind::kIcp:
    case MethodKind::kDclocIcp:
      return MakeIcpRegistration();
    case MethodKind::kNdt:
    case MethodKind::kDclocNdt:
      return MakeNdtRegistration();
    case MethodKind::kDclocGicp:
      return MakePclGicpRegistration();
    case MethodKind::kMcRansac:
      return std::make_unique<DescriptorRegistration>(std::nullopt);
    default:
      return std::make_unique<DescriptorRegistration>(options.matcher.gicp);
  }
}

}  // namespace

std::string MethodName(MethodKind kind) {
  for (const auto& [name, value] : kMethodNames) {
    if (value == kind) return name;
  }
  return "";
}

bool RunsInLocalizer(MethodKind kind) { return kind >= MethodKind::kDcloc; }

absl::StatusOr<std::unique_ptr<Method>> CreateMethod(MethodKind kind,
                                                     const std::shared_ptr<const RadarMap>& map,
                                                     const Rig& rig,
                                                     const std::optional<InitialPose>& initial_pose,
                                                     const LocalizerOptions& options) {
  // Checks what every method is given.
  auto ours = Localizer::Create(map, rig, initial_pose, options);
  if (!ours.ok()) return ours.status();
  if (kind == MethodKind::kDcloc) return std::make_unique<Ours>(*std::move(ours));
  if (RunsInLocalizer(kind)) {
    if (map->info().has_elevation && rig.MeasuresElevation()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "method ", MethodName(kind), " is planar, but map and rig both measure elevation"));
    }
    auto localizer = Localizer::Create(map, rig, initial_pose, options,
                                       {.planar = std::make_shared<MethodInLocalizer>(
                                            MakeRegistration(kind, options), options.matcher.gicp),
                                        .spatial = nullptr});
    if (!localizer.ok()) return localizer.status();
    return std::make_unique<Ours>(*std::move(localizer));
  }
  if (!initial_pose) {
    return absl::InvalidArgumentError(absl::StrCat(
        "method ", MethodName(kind),
        " needs an initial pose: only those inside the localizer search the whole map"));
  }
  const Pose3 T_map_local =
      Baseline::LocalFrame(*map, initial_pose->T_map_vehicle.translation_m, options);
  const PoseEstimate<2> initial{
      .pose = Flatten(T_map_local.Inverse() * initial_pose->T_map_vehicle),
      .covariance = FlattenCovariance(initial_pose->covariance)};
  // Without truncation the paper has no graph (Table II).
  const bool has_graph = kind == MethodKind::kDcLocPlusPlus && options.gate_outliers;
  return std::make_unique<Baseline>(
      map, T_map_local,
      Baseline::Parts{.front_end = FrontEnd(rig, options, kind == MethodKind::kMcRansac),
                      .registration = MakeRegistration(kind, options),
                      .estimator = has_graph ? MakeGraphEstimator(initial, options)
                                             : MakeFrameEstimator(initial)},
      options);
}

}  // namespace dcloc
