#pragma once

#include <memory>
#include <optional>

#include "client/evaluation/baselines/estimator.h"
#include "client/evaluation/baselines/front_end.h"
#include "client/evaluation/baselines/method.h"
#include "client/evaluation/baselines/planar_registration.h"

namespace dcloc {

/// The course that all compared methods share: sub-map, prediction, registration in the landmarks
/// around the prediction, estimate. Works in the plane of the map's keyframes.
class Baseline final : public Method {
 public:
  struct Parts {
    FrontEnd front_end;
    std::unique_ptr<PlanarRegistration> registration;
    std::unique_ptr<Estimator> estimator;
  };

  /// What is the same for all: `parts.estimator` begins in the local frame that
  /// `LocalFrame(*map, initial_pose)` gives.
  Baseline(std::shared_ptr<const RadarMap> map, const Pose3& T_map_local, Parts parts,
           const LocalizerOptions& options);

  absl::StatusOr<Localization> Localize(const Scan& scan, StageListener* listener) override;

  /// The frame of the keyframe nearest to `p_map`; the identity where there is none within reach.
  static Pose3 LocalFrame(const RadarMap& map, const Eigen::Vector3d& p_map,
                          const LocalizerOptions& options);

 private:
  void EnterLocalFrame();
  void Register(const Submap& submap, Stamp stamp, StageListener* listener);
  Localization Answer(Stamp stamp) const;

  std::shared_ptr<const RadarMap> map_;
  LocalizerOptions options_;
  Parts parts_;
  Pose3 T_map_local_;
  std::optional<std::size_t> keyframe_;  // that the local map is of
  LocalMap<2> local_map_;
  std::optional<Stamp> last_accepted_;
  LocalizationQuality quality_;
};

}  // namespace dcloc
