#include "core/uncertainty/beta_monitor.h"

#include <gtest/gtest.h>

#include <random>

#include "core/registration/point_jacobians.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

constexpr double kSigma_m = 0.15;

Rig FrontAndRear() {
  RadarModel front{.id = "front"};
  front.T_vehicle_radar.translation_m = {3.5, 0.2, 0.5};
  RadarModel rear{.id = "rear"};
  rear.T_vehicle_radar.translation_m = {-1.0, 0.4, 0.5};
  rear.T_vehicle_radar.rotation = Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitZ());
  return {.radars = {front, rear}};
}

// Errors of the two radars' betas and of what must not pass for one.
struct Wrong {
  double front_beta_s = 0.0;
  double rear_beta_s = 0.0;
  double front_time_offset_s = 0.0;
  double front_mount_yaw_rad = 0.0;
  double speed_mps = 12.0;
};

// A registration a second for as long as the watch is given, of points whose landmarks are where
// the radars' true descriptions put them.
template <int Dim>
class Street {
 public:
  explicit Street(const Wrong& wrong) : wrong_(wrong), monitor_(FrontAndRear()) {}

  const BetaMonitor<Dim>& Drive(int seconds) {
    for (int i = 0; i < seconds; ++i) Register(Stamp(milliseconds(1000 * i)));
    return monitor_;
  }

 private:
  void Register(Stamp stamp) {
    const Rig rig = FrontAndRear();
    const EgoVelocity ego_velocity{.linear_mps = {wrong_.speed_mps, 0.0, 0.0}};
    Pose<Dim> T_local_vehicle;
    T_local_vehicle.translation_m.x() = 100.0;
    LiveSubmap<Dim> live;
    std::vector<Correspondence<Dim>> matches;
    for (int radar = 0; radar < 2; ++radar) {
      const Pose3& mount = rig.radars[static_cast<std::size_t>(radar)].T_vehicle_radar;
      const std::size_t begin = live.points.size();
      for (int i = 0; i < 200; ++i)
        AddPoint(radar, mount, ego_velocity, T_local_vehicle, live, matches);
      live.parts.push_back({.radar_index = radar, .begin = begin, .end = live.points.size()});
    }
    monitor_.OnRegistration(stamp, live, matches, T_local_vehicle, ego_velocity);
  }

  void AddPoint(int radar, const Pose3& mount, const EgoVelocity& ego_velocity,
                const Pose<Dim>& T_local_vehicle, LiveSubmap<Dim>& live,
                std::vector<Correspondence<Dim>>& matches) {
    const double range_m = std::uniform_real_distribution<double>(5.0, 90.0)(random_);
    const double azimuth_rad = std::uniform_real_distribution<double>(-1.1, 1.1)(random_);
    const Eigen::Vector3d p_m =
        mount * (range_m * Eigen::Vector3d(std::cos(azimuth_rad), std::sin(azimuth_rad), 0.0));
    const Eigen::Matrix<double, Dim, 1> p = p_m.head<Dim>();
    Eigen::Matrix<double, kRadarErrors, 1> errors = Eigen::Matrix<double, kRadarErrors, 1>::Zero();
    errors(kBetaError) = radar == 0 ? wrong_.front_beta_s : wrong_.rear_beta_s;
    if (radar == 0) errors(kTimeOffsetError) = wrong_.front_time_offset_s;
    if (radar == 0) errors(kMountYawError) = wrong_.front_mount_yaw_rad;
    Eigen::Matrix<double, Dim, 1> q =
        p + ByRadarErrors<Dim>(p, mount.translation_m, ego_velocity) * errors;
    std::normal_distribution<double> noise(0.0, kSigma_m);
    for (int axis = 0; axis < Dim; ++axis) q(axis) += noise(random_);
    const Eigen::Matrix<double, Dim, Dim> covariance =
        kSigma_m * kSigma_m * Eigen::Matrix<double, Dim, Dim>::Identity();
    live.points.push_back({.mean_m = p, .covariance_m2 = covariance});
    // Some points have no landmark.
    if (std::uniform_int_distribution<int>(0, 4)(random_) == 0) return;
    matches.push_back({.p = p, .q = T_local_vehicle * q, .information = covariance.inverse()});
  }

  Wrong wrong_;
  BetaMonitor<Dim> monitor_;
  std::mt19937_64 random_{7};
};

TEST(BetaMonitorTest, FindsAWrongBetaOfOneRadarAndNotOfTheOther) {
  Street<2> street({.front_beta_s = 0.04});
  const BetaMonitor<2>& watch = street.Drive(60);
  EXPECT_NEAR(watch.Check(0).error_s, 0.04, 0.004);
  EXPECT_TRUE(watch.Check(0).is_wrong);
  EXPECT_NEAR(watch.Check(1).error_s, 0.0, 0.004);
  EXPECT_FALSE(watch.Check(1).is_wrong);
}

TEST(BetaMonitorTest, FindsTheSign) {
  Street<2> street({.rear_beta_s = -0.03});
  EXPECT_NEAR(street.Drive(60).Check(1).error_s, -0.03, 0.004);
}

TEST(BetaMonitorTest, WorksInSpace) {
  Street<3> street({.front_beta_s = 0.04});
  const BetaMonitor<3>& watch = street.Drive(60);
  EXPECT_NEAR(watch.Check(0).error_s, 0.04, 0.004);
  EXPECT_FALSE(watch.Check(1).is_wrong);
}

TEST(BetaMonitorTest, ClocksAndMountsAreNoWrongBeta) {
  Street<2> street({.front_time_offset_s = 0.05, .front_mount_yaw_rad = 0.01});
  const BetaMonitor<2>& watch = street.Drive(60);
  EXPECT_NEAR(watch.Check(0).error_s, 0.0, 0.004);
  EXPECT_FALSE(watch.Check(0).is_wrong);
}

TEST(BetaMonitorTest, AStandingVehicleShowsNothing) {
  Street<2> street({.front_beta_s = 0.04, .speed_mps = 0.0});
  const BetaCheck check = street.Drive(60).Check(0);
  EXPECT_NEAR(check.error_s, 0.0, 1e-9);
  EXPECT_GT(check.sigma_s, 0.04);
  EXPECT_FALSE(check.is_wrong);
}

TEST(BetaMonitorTest, SaysNothingBeforeTheFirstRegistration) {
  const BetaMonitor<2> watch(FrontAndRear());
  EXPECT_EQ(watch.Check(0).error_s, 0.0);
  EXPECT_FALSE(watch.Check(0).is_wrong);
}

TEST(BetaMonitorTest, LooksAtRegistrationsThatShareNoScan) {
  Street<2> street({});
  const BetaMonitor<2>& watch = street.Drive(1);
  EXPECT_FALSE(watch.IsDue(Stamp(milliseconds(600)), milliseconds(700)));
  EXPECT_TRUE(watch.IsDue(Stamp(milliseconds(800)), milliseconds(700)));
}

}  // namespace
}  // namespace dcloc
