#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "core/odometry/source_monitor.h"
#include "core/radar/static_points.h"

namespace dcloc {
namespace {

constexpr double kInterval_s = 0.075;
constexpr double kTrue_mps = 20.0;

// How far off a range rate the gate of static targets lets pass [m/s].
double GateOf(const SourceMonitor::Spread& spread) {
  const StaticPointsOptions gate;
  return gate.static_gate_mps + gate.static_gate_sigmas * std::sqrt(spread.speed_variance);
}

// A vehicle at 20 m/s from its first scan on. Of its motion, that of the best sources is used.
class VehicleOfTwoSpeeds {
 public:
  explicit VehicleOfTwoSpeeds(double wheel_mps, const StaticPointsOptions& static_points = {})
      : monitor({}, static_points), wheel_mps_(wheel_mps) {}

  void Scan(bool has_doppler = true) {
    stamp_ += std::chrono::milliseconds(75);
    OdometryReadings readings{.wheel_speed = ScalarEstimate{wheel_mps_, 0.01},
                              .yaw_rate = ScalarEstimate{0.0, 1e-4}};
    if (has_doppler) {
      readings.doppler_speed = ScalarEstimate{kTrue_mps, 0.01};
      readings.doppler_direction_count = 7;
    }
    monitor.OnReadings(stamp_, readings);
    const double step_s = std::exchange(has_begun_, true) ? kInterval_s : 0.0;
    used_m += monitor.speed().value * step_s;
    const auto unapplied = monitor.OnUsedMotion(monitor.speed().value * step_s, 0.0);
    if (unapplied) used_m += unapplied->forward_m;
  }
  void Scans(int count) {
    for (int i = 0; i < count; ++i) Scan();
  }
  // Scans that lie in the map where a vehicle at `speed_mps` is.
  void ScansThatFitAt(double speed_mps, int count) {
    for (int i = 0; i < count; ++i) {
      Scan();
      const auto alternative = monitor.Alternative(0);
      if (!alternative) continue;
      const bool uses = std::abs(monitor.speed().value - speed_mps) < 1.0;
      monitor.OnFits(0, *alternative, uses ? 0.7 : 0.2, uses ? 0.2 : 0.7);
    }
  }

  SourceMonitor monitor;
  double used_m = 0.0;  // the way by the motion that was used

 private:
  double wheel_mps_;
  bool has_begun_ = false;
  Stamp stamp_{std::chrono::seconds(1'000)};
};

TEST(SourceSpreadTest, SourcesThatAgreeHaveNoSpread) {
  VehicleOfTwoSpeeds vehicle(kTrue_mps);
  vehicle.Scans(40);
  const SourceMonitor::Spread spread = vehicle.monitor.CurrentSpread();
  EXPECT_LT(spread.along_track_bound_m, 0.05);
  EXPECT_LT(spread.along_track_variance_m2, 1e-3);
  EXPECT_LT(spread.speed_variance, 1e-2);
  EXPECT_FALSE(vehicle.monitor.Alternative(0));
}

TEST(SourceSpreadTest, OnlyWhatTheGateOfStaticTargetsDoesNotReachWidensIt) {
  VehicleOfTwoSpeeds usual(0.7 * kTrue_mps);
  VehicleOfTwoSpeeds wide(0.7 * kTrue_mps,
                          {.static_gate_mps = 10.0});  // farther than the sources are
  VehicleOfTwoSpeeds fixed(0.7 * kTrue_mps, {.static_gate_sigmas = 0.0});
  for (VehicleOfTwoSpeeds* vehicle : {&usual, &wide, &fixed}) vehicle->Scan();
  EXPECT_GT(usual.monitor.CurrentSpread().speed_variance, 0.1);
  EXPECT_EQ(wide.monitor.CurrentSpread().speed_variance, 0.0);
  EXPECT_EQ(fixed.monitor.CurrentSpread().speed_variance, 0.0);
}

TEST(SourceSpreadTest, TheAlongTrackSpreadIsWhatTheSourcesDifferBy) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  const double apart_m = 0.3 * kTrue_mps * 4 * kInterval_s;  // since the first scan
  const SourceMonitor::Spread spread = vehicle.monitor.CurrentSpread();
  EXPECT_NEAR(spread.along_track_bound_m, apart_m, 0.1);
  EXPECT_GT(GateOf(spread), 0.15 * kTrue_mps) << "half of what they differ by";
  EXPECT_GT(std::sqrt(spread.along_track_variance_m2), 0.3 * apart_m);
  const auto alternative = vehicle.monitor.Alternative(0);
  ASSERT_TRUE(alternative);
  EXPECT_NEAR(std::abs(alternative->forward_m), apart_m, 0.1);
}

TEST(SourceSpreadTest, WhereScansFitDecides) {
  for (const double right_mps : {kTrue_mps, 0.7 * kTrue_mps}) {
    VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
    vehicle.ScansThatFitAt(right_mps, 12);
    EXPECT_NEAR(vehicle.monitor.speed().value, right_mps, 0.5);
    EXPECT_FALSE(vehicle.monitor.Alternative(0));
    EXPECT_LT(vehicle.monitor.CurrentSpread().speed_variance, 0.1);
  }
}

TEST(SourceSpreadTest, FitsThatAreEqualDecideNothing) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  const double before = vehicle.monitor.confidence();
  const auto alternative = vehicle.monitor.Alternative(0);
  ASSERT_TRUE(alternative);
  vehicle.monitor.OnFits(0, *alternative, 0.5, 0.5);
  EXPECT_NEAR(vehicle.monitor.confidence(), before, 1e-9);
  EXPECT_FALSE(vehicle.monitor.Alternative(0)) << "the same scan counts once";
}

TEST(SourceSpreadTest, ScansOfEachRadarCount) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  const auto alternative = vehicle.monitor.Alternative(0);
  ASSERT_TRUE(alternative);
  vehicle.monitor.OnFits(0, *alternative, 0.5, 0.5);
  EXPECT_FALSE(vehicle.monitor.Alternative(0));
  EXPECT_TRUE(vehicle.monitor.Alternative(3)) << "of the same moment";
}

TEST(SourceSpreadTest, ASourceIsRuledOutOnceNothingProbableTrustsIt) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  EXPECT_FALSE(vehicle.monitor.IsRuledOut(OdometrySource::kWheelSpeed));
  EXPECT_FALSE(vehicle.monitor.IsRuledOut(OdometrySource::kDoppler));
  vehicle.ScansThatFitAt(kTrue_mps, 30);
  EXPECT_TRUE(vehicle.monitor.IsRuledOut(OdometrySource::kWheelSpeed));
  EXPECT_FALSE(vehicle.monitor.IsRuledOut(OdometrySource::kDoppler));
}

// What the others say is then besides what the pose was moved by.
TEST(SourceSpreadTest, TheSpreadOutlivesAChangeOfTheSources) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  const double speed_mps = vehicle.monitor.speed().value;
  const auto alternative = vehicle.monitor.Alternative(0);
  ASSERT_TRUE(alternative);
  vehicle.monitor.OnFits(0, *alternative, 0.2, 0.7);
  vehicle.Scan();
  ASSERT_GT(std::abs(vehicle.monitor.speed().value - speed_mps), 1.0) << "the alternative is used";
  EXPECT_NEAR(vehicle.monitor.CurrentSpread().along_track_bound_m,
              0.3 * kTrue_mps * 5 * kInterval_s, 0.2);
}

TEST(SourceSpreadTest, ARegistrationThatIsAcceptedEndsTheAlongTrackSpread) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  vehicle.monitor.OnRegistration(Pose2{}, {});
  EXPECT_EQ(vehicle.monitor.CurrentSpread().along_track_bound_m, 0.0);
  EXPECT_GT(vehicle.monitor.CurrentSpread().speed_variance, 1.0) << "which speed is right, is open";
}

// They lie where the used motion has put them, whichever it was.
TEST(SourceSpreadTest, BetweenSmoothWallsRegistrationsSpeakForNoSpeed) {
  const auto confidence_after = [](bool observes_along_track) {
    VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
    for (int i = 0; i < 8; ++i) {
      vehicle.Scan();
      vehicle.monitor.OnRegistration(
          Pose2{{vehicle.used_m, 0.0}, 0.0},
          {.is_accepted = false, .observes_along_track = observes_along_track});
    }
    return vehicle.monitor.confidence();
  };
  EXPECT_LT(confidence_after(false), 0.95);
  EXPECT_GT(confidence_after(true), 0.99);
}

TEST(SourceSpreadTest, AScanWithoutDopplerEndsNoSpread) {
  VehicleOfTwoSpeeds vehicle(0.7 * kTrue_mps);
  vehicle.Scans(5);
  const double before_m = vehicle.monitor.CurrentSpread().along_track_bound_m;
  vehicle.Scan(/*has_doppler=*/false);
  EXPECT_GT(vehicle.monitor.CurrentSpread().along_track_bound_m, before_m);
  EXPECT_GT(GateOf(vehicle.monitor.CurrentSpread()), 0.15 * kTrue_mps);
}

// The gate of static targets has room for both.
TEST(SourceSpreadTest, SpeedsThatDifferByLittleWidenNoGate) {
  VehicleOfTwoSpeeds vehicle(kTrue_mps - 0.25);
  vehicle.Scans(10);
  EXPECT_EQ(vehicle.monitor.CurrentSpread().speed_variance, 0.0);
}

TEST(SourceSpreadTest, TheGateReachesNotMuchBeyondWhatTheSourcesDifferBy) {
  for (const double apart_mps : {0.5, 1.0, 3.0, 6.0}) {
    VehicleOfTwoSpeeds vehicle(kTrue_mps - apart_mps);
    vehicle.Scans(5);
    EXPECT_LT(GateOf(vehicle.monitor.CurrentSpread()), 2.0 * apart_mps) << apart_mps;
  }
}

}  // namespace
}  // namespace dcloc
