#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {

inline constexpr double kDegree = std::numbers::pi / 180.0;
inline constexpr double kMapSpeed_mps = 8.0;
inline constexpr double kLiveSpeed_mps = 14.0;

/// Of the answers that claim to track.
struct Errors {
  int tracking_count = 0;
  double mean_m = 0.0;
  double max_m = 0.0;
  double max_rad = 0.0;
  int first_tracking = -1;
};

inline Errors ErrorsOf(const std::vector<TrueAnswer>& answers) {
  Errors errors;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!answers[i].tracking()) continue;
    if (errors.first_tracking < 0) errors.first_tracking = static_cast<int>(i);
    ++errors.tracking_count;
    errors.mean_m += answers[i].position_error_m();
    errors.max_m = std::max(errors.max_m, answers[i].position_error_m());
    errors.max_rad = std::max(errors.max_rad, answers[i].yaw_error_rad());
  }
  errors.mean_m /= std::max(1, errors.tracking_count);
  return errors;
}

/// One map and one drive over it at another speed, for all tests of a suite.
class OnARoad : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const SyntheticWorld world;
    map_ = MapOfDrive(DriveRoad(world, FrontRadar(), kMapSpeed_mps, 1), FrontRadar());
    drive_ = DriveRoad(world, FrontRadar(), kLiveSpeed_mps, 2);
  }
  static void TearDownTestSuite() {
    map_.reset();
    drive_.clear();
  }

  static Pose3 Start() { return drive_.front().T_map_vehicle; }

  static inline std::shared_ptr<const RadarMap> map_;
  static inline std::vector<TrueScan> drive_;
};

}  // namespace dcloc
