#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "client/evaluation/baselines/method.h"
#include "client/evaluation/outcome.h"
#include "client/evaluation/perturbation.h"
#include "core/localizer/localizer.h"

namespace dcloc {

enum class Protocol {
  kTrack,  ///< one session from the drive's first scan to its last
  /// Separate queries at fixed intervals, each a fresh session with a fresh perturbed prior that
  /// is given the last scans of each radar only, judged at the last of them.
  kPairs,
};

struct EvaluationOptions {
  MethodKind method = MethodKind::kDcloc;
  Protocol protocol = Protocol::kTrack;
  bool has_initial_pose = true;  ///< else the whole map is searched (see RunsInLocalizer)
  Perturbation perturbation;
  bool doppler_ego_velocity = false;  ///< take the drive's ego-velocity away from the localizer
  bool map_heights = true;            ///< of landmarks, where the map is made for the run
  double query_interval_s = 0.5;      ///< kPairs: between queries, [0.01, 1000]
  double first_query_s = 2.0;         ///< kPairs: from the drive's first scan
  LocalizerOptions localizer;
};

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const EvaluationOptions& options);

/// Localizes `drive` in `map` and judges the answers by the drive's reference poses, which must be
/// in the map's frame. Scans that the localizer refuses are counted, not an error. `progress` is
/// told the share done. InvalidArgument for invalid options, a null map, a drive without scans and
/// an invalid rig.
absl::StatusOr<DriveOutcome> Evaluate(
    const std::shared_ptr<const RadarMap>& map, const Drive& drive,
    const EvaluationOptions& options, const std::function<void(double)>& progress = [](double) {});

}  // namespace dcloc
