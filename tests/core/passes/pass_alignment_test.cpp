#include "core/passes/pass_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/passes/street_fixture.h"

namespace dcloc {
namespace {

std::vector<LandmarkPosition> PositionsOf(const EditableMap& map) {
  std::vector<LandmarkPosition> positions;
  for (const PlacedLandmark& landmark : LandmarksOf(map)) positions.push_back(landmark.position);
  return positions;
}

/// The mean of where the poses lie beside the true ones: scan i is at x = i.
Eigen::Vector2d MeanError_m(const PlacedPass& pass) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < pass.scans.size(); ++i) {
    sum += pass.scans[i].T_map_vehicle.translation_m.head<2>() -
           Eigen::Vector2d(static_cast<double>(i), 0.0);
  }
  return sum / static_cast<double>(pass.scans.size());
}

TEST(PassAlignmentTest, APassThatLiesToOneSideIsBroughtBack) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  PlacedPass pass = street.Pass(1, "a", {0.1, 0.05, 0.0});
  ASSERT_NEAR(MeanError_m(pass).x(), 0.1, 1e-6);
  AlignPass({PositionsOf(base), {}}, base.Origin_m(), {}, pass);
  EXPECT_LT(MeanError_m(pass).norm(), 0.02);
}

TEST(PassAlignmentTest, PosesThatScatterAreSmoothedByOdometry) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  PlacedPass pass = street.Pass(1, "a");
  for (std::size_t i = 0; i < pass.scans.size(); ++i) {
    pass.scans[i].T_map_vehicle.translation_m.y() += (i / 10) % 2 == 0 ? 0.1 : -0.1;
  }
  AlignPass({PositionsOf(base), {}}, base.Origin_m(), {}, pass);
  double worst_m = 0.0;
  for (const PlacedScan& scan : pass.scans) {
    worst_m = std::max(worst_m, std::abs(scan.T_map_vehicle.translation_m.y()));
  }
  EXPECT_LT(worst_m, 0.06);
}

TEST(PassAlignmentTest, TheScaleOfOdometryIsFound) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  PlacedPass pass = street.Pass(1, "a");
  for (PlacedScan& scan : pass.scans) scan.T_start_vehicle.translation_m *= 1.01;
  AlignPass({PositionsOf(base), {}}, base.Origin_m(), {}, pass);
  EXPECT_LT(MeanError_m(pass).norm(), 0.03);
  const double length_m = pass.scans.back().T_map_vehicle.translation_m.x() -
                          pass.scans.front().T_map_vehicle.translation_m.x();
  EXPECT_NEAR(length_m, TestStreet::kLength_m, 0.15);
}

TEST(PassAlignmentTest, WithoutScansThatCountNothingHappens) {
  const TestStreet street;
  const EditableMap base = street.Map(0);
  PlacedPass pass = street.Pass(1, "a", {0.1, 0.0, 0.0});
  for (PlacedScan& scan : pass.scans) scan.is_good = false;
  AlignPass({PositionsOf(base), {}}, base.Origin_m(), {}, pass);
  EXPECT_NEAR(MeanError_m(pass).x(), 0.1, 1e-9);
}

}  // namespace
}  // namespace dcloc
