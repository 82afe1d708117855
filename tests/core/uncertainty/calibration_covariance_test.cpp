#include "core/uncertainty/calibration_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>
#include <vector>

namespace dcloc {
namespace {

constexpr double kError = 1e-4;  // [s, m, s, rad]: small, so that shifts are linear in it

// Two radars on one vehicle that goes round a bend; each has seen its points in two scans.
class CalibrationCovarianceTest : public ::testing::Test {
 protected:
  CalibrationCovarianceTest() {
    rig_.radars = {{.id = "left"}, {.id = "right"}};
    rig_.radars[0].T_vehicle_radar.translation_m = {3.0, 1.0, 0.0};
    rig_.radars[1].T_vehicle_radar.translation_m = {3.0, -1.0, 0.0};
    for (RadarModel& radar : rig_.radars) {
      radar.beta_sigma_s = radar.range_bias_sigma_m = 0.0;
      radar.time_offset_sigma_s = radar.mount_yaw_sigma_rad = 0.0;
    }
    velocity_.linear_mps = {12.0, 0.5, 0.0};
    velocity_.angular_radps = {0.0, 0.0, 0.2};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> ahead(5.0, 60.0);
    std::uniform_real_distribution<double> across(1.0, 30.0);
    std::uniform_real_distribution<double> variance(0.02, 0.5);
    for (int scan = 0; scan < 4; ++scan) {
      const std::size_t begin = live_.points.size();
      const double side = scan % 2 == 0 ? 1.0 : -1.0;
      for (int i = 0; i < 40; ++i) {
        live_.points.push_back({.mean_m = {ahead(random), side * across(random)},
                                .covariance_m2 = variance(random) * Eigen::Matrix2d::Identity()});
      }
      const Pose2 T_newest_then{.translation_m = {-0.4 * scan, 0.0}, .yaw_rad = 0.0};
      live_.parts.push_back({scan % 2, Embed(T_newest_then), begin, live_.points.size()});
    }
  }

  // By how far the best pose moves when `shift(p, origin)` moves the points of radar 0: weighted
  // least squares on the stacked equations.
  template <typename Shift>
  Eigen::Vector3d MovedPose(const Shift& shift) const {
    const auto rows = static_cast<Eigen::Index>(2 * live_.points.size());
    Eigen::MatrixXd by_pose(rows, 3);
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(rows);
    for (const auto& part : live_.parts) {
      const Eigen::Vector2d origin_m =
          (part.T_newest_then *
           rig_.radars[static_cast<std::size_t>(part.radar_index)].T_vehicle_radar.translation_m)
              .head<2>();
      for (std::size_t i = part.begin; i < part.end; ++i) {
        const Eigen::Vector2d& p_m = live_.points[i].mean_m;
        const double weight = 1.0 / std::sqrt(live_.points[i].covariance_m2(0, 0));
        const auto row = static_cast<Eigen::Index>(2 * i);
        by_pose.row(row) << weight, 0.0, -weight * p_m.y();
        by_pose.row(row + 1) << 0.0, weight, weight * p_m.x();
        if (part.radar_index == 0) {
          moved.segment<2>(row) = weight * (shift(p_m, origin_m) - p_m);
        }
      }
    }
    return by_pose.colPivHouseholderQr().solve(moved);
  }

  template <typename Shift>
  void ExpectCovarianceOf(const Shift& shift) const {
    const Eigen::Vector3d moved = MovedPose(shift);
    const Eigen::Matrix3d covariance = CalibrationCovariance<2>(live_, rig_, velocity_);
    EXPECT_GT(moved.norm(), 0.1 * kError);
    EXPECT_LT((covariance - moved * moved.transpose()).norm(), 0.02 * moved.squaredNorm());
  }

  RadarModel& radar() { return rig_.radars[0]; }
  Eigen::Vector2d VelocityAt(const Eigen::Vector2d& p_m) const {
    return velocity_.linear_mps.head<2>() +
           velocity_.angular_radps.z() * Eigen::Vector2d(-p_m.y(), p_m.x());
  }

  Rig rig_;
  EgoVelocity velocity_;
  LiveSubmap<2> live_;
};

TEST_F(CalibrationCovarianceTest, ARigThatIsKnownAddsNothing) {
  EXPECT_EQ(CalibrationCovariance<2>(live_, rig_, velocity_).norm(), 0.0);
}

TEST_F(CalibrationCovarianceTest, AMountsYawTurnsThePointsAboutTheRadar) {
  radar().mount_yaw_sigma_rad = kError;
  ExpectCovarianceOf([](const Eigen::Vector2d& p_m, const Eigen::Vector2d& origin_m) {
    return Eigen::Vector2d(origin_m + Eigen::Rotation2Dd(kError) * (p_m - origin_m));
  });
}

TEST_F(CalibrationCovarianceTest, ARangeBiasMovesThePointsAway) {
  radar().range_bias_sigma_m = kError;
  ExpectCovarianceOf([](const Eigen::Vector2d& p_m, const Eigen::Vector2d& origin_m) {
    return Eigen::Vector2d(p_m + kError * (p_m - origin_m).normalized());
  });
}

TEST_F(CalibrationCovarianceTest, ATimeOffsetMovesThePointsWithTheVehicle) {
  radar().time_offset_sigma_s = kError;
  ExpectCovarianceOf([this](const Eigen::Vector2d& p_m, const Eigen::Vector2d&) {
    return Eigen::Vector2d(p_m + kError * VelocityAt(p_m));
  });
}

TEST_F(CalibrationCovarianceTest, BetaMovesThePointsByTheirRangeRate) {
  radar().beta_sigma_s = kError;
  ExpectCovarianceOf([this](const Eigen::Vector2d& p_m, const Eigen::Vector2d& origin_m) {
    const Eigen::Vector2d along = (p_m - origin_m).normalized();
    return Eigen::Vector2d(p_m - kError * -along.dot(VelocityAt(origin_m)) * along);
  });
}

TEST_F(CalibrationCovarianceTest, ErrorsOfTwoRadarsAddUp) {
  rig_.radars[0].mount_yaw_sigma_rad = kError;
  const Eigen::Matrix3d left = CalibrationCovariance<2>(live_, rig_, velocity_);
  rig_.radars[0].mount_yaw_sigma_rad = 0.0;
  rig_.radars[1].mount_yaw_sigma_rad = kError;
  const Eigen::Matrix3d right = CalibrationCovariance<2>(live_, rig_, velocity_);
  rig_.radars[0].mount_yaw_sigma_rad = kError;
  const Eigen::Matrix3d both = CalibrationCovariance<2>(live_, rig_, velocity_);
  EXPECT_LT((both - left - right).norm(), 1e-12 * both.norm());
}

TEST_F(CalibrationCovarianceTest, PointsInThePlaneGiveTheSameInSpace) {
  rig_.radars[0].mount_yaw_sigma_rad = rig_.radars[1].range_bias_sigma_m = kError;
  LiveSubmap<3> in_space;
  for (const GaussianPoint<2>& point : live_.points) {
    const double variance_m2 = point.covariance_m2(0, 0);
    in_space.points.push_back({.mean_m = {point.mean_m.x(), point.mean_m.y(), 0.0},
                               .covariance_m2 = variance_m2 * Eigen::Matrix3d::Identity()});
  }
  for (const auto& part : live_.parts) {
    in_space.parts.push_back({part.radar_index, part.T_newest_then, part.begin, part.end});
  }
  const Eigen::Matrix3d planar = CalibrationCovariance<2>(live_, rig_, velocity_);
  const Matrix6d spatial = CalibrationCovariance<3>(in_space, rig_, velocity_);
  const int rows[] = {0, 1, 5};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(spatial(rows[i], rows[j]), planar(i, j), 1e-6 * planar.norm());
    }
  }
}

}  // namespace
}  // namespace dcloc
