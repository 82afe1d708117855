#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/disturbance.h"
#include "client/evaluation/perturbation.h"
#include "client/evaluation/robustness/course.h"
#include "client/evaluation/robustness/tally.h"
#include "core/map/radar_map.h"

namespace dcloc::robustness {

/// Sessions over a whole drive, or over one part after another.
struct TrackTrial {
  Perturbation prior;
  std::optional<DisturbancePlan> plan;  ///< nothing for the drive as it is
  std::optional<double> session_s;      ///< of each part, [1, 1e6]; the whole drive where absent
};

/// What a session knows when it starts.
enum class Prior {
  kPose,  ///< a pose that is wrong by the trial's perturbation
  kGnss,  ///< a position with a deviation of the perturbation's translation, and no heading
  kNone,
};

/// Many sessions, one every `spacing_m` of the path, each until it calls itself tracking or has had
/// `limit_s` of data.
struct StartTrial {
  Prior prior = Prior::kPose;
  Perturbation perturbation;
  double spacing_m = 7.0;  ///< [0.1, 1e6]
  double limit_s = 3.0;    ///< [0.1, 1e6]
};

using Trial = std::variant<TrackTrial, StartTrial>;

/// OK, or InvalidArgument that names the field, the value and the bound.
absl::Status Validate(const Trial& trial);

/// Does a trial of `course` in `map`; `progress` receives the share done. InvalidArgument for an
/// invalid trial or rig, a null map and a drive without scans.
absl::StatusOr<Tally> RunTrial(const Trial& trial, const Course& course,
                               const std::shared_ptr<const RadarMap>& map,
                               const std::function<void(double)>& progress);

}  // namespace dcloc::robustness
