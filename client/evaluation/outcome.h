#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/pose_error.h"
#include "core/localizer/localizer.h"
#include "core/map/radar_map.h"

namespace dcloc {

/// One judged answer.
struct ScanOutcome {
  std::string radar_id;
  Localization answer;
  Pose3 T_map_vehicle_true;
  PoseError error;
  std::array<std::optional<double>, kStageNames.size()> stage_ms;  ///< of the stages that ran
  double total_ms = 0.0;
  /// Against the map drive at the same place, where a study looks at it.
  std::optional<double> speed_difference_mps;

  /// An answer is a pose in the map once the localizer has confirmed one.
  bool answered() const { return answer.state != LocalizationState::kInitializing; }
};

/// The judged answers of one live drive.
struct DriveOutcome {
  std::string drive;
  std::shared_ptr<const RadarMap> map;  ///< it was localized in
  std::vector<ScanOutcome> scans;  ///< those that the localizer took, in the order of their stamps
  std::size_t refused_count = 0;
  std::string first_refusal;  ///< the localizer's error for the first scan that it refused
};

}  // namespace dcloc
