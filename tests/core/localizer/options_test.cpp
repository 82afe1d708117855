#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "core/localizer/localizer_options.h"
#include "tests/core/options/option_fields_check.h"

namespace dcloc {
namespace {

using ::testing::StartsWith;

template <typename Options>
class StageOptionsTest : public ::testing::Test {};

using AllOptions = ::testing::Types<
    EgoVelocityOptions, EgoMotionOptions, NoiseScaleOptions, BetaMonitorOptions, MotionOptions,
    OdometryErrorFilterOptions, StaticPointsOptions, RegistrationScheduleOptions, GicpOptions,
    RegistrationGate, MapMatcherOptions, PosePriorOptions, GlobalLocalizerOptions,
    RegistrationFactorOptions, PoseGraphOptions, TrackingOptions, UnobservedSigmas, MountYawOptions,
    LearnedRigOptions, RadarMonitorOptions, FixMonitorOptions, ResetOptions, ProtectionLevelOptions,
    SourceMonitorOptions, ObservabilityOptions, RadarClocksOptions, LocalizerOptions>;
TYPED_TEST_SUITE(StageOptionsTest, AllOptions);

TYPED_TEST(StageOptionsTest, EachFieldIsBounded) { ExpectEachFieldIsBounded<TypeParam>(); }

TEST(LocalizerOptionsTest, NamesAFieldByItsStage) {
  LocalizerOptions options;
  options.ego_motion.motion.correlation_time = -std::chrono::seconds(1);
  EXPECT_EQ(Validate(options).message(),
            "ego_motion.motion.correlation_time_ms is -1000; it must lie in [1, 1e+06]");
}

TEST(LocalizerOptionsTest, AStagesSwitchIsRefusedWhereTheLocalizerOwnsIt) {
  LocalizerOptions options;
  options.static_points.compensate = false;
  EXPECT_EQ(Validate(options).message(),
            "static_points.compensate is false; set doppler_compensation to false instead, which "
            "owns it");
  options = {};
  options.static_points.per_point_covariance = false;
  EXPECT_THAT(std::string(Validate(options).message()),
              StartsWith("static_points.per_point_covariance"));
  options = {};
  options.pose_graph.gate_outliers = false;
  EXPECT_THAT(std::string(Validate(options).message()), StartsWith("pose_graph.gate_outliers"));
  options = {};
  options.doppler_compensation = options.per_point_covariance = options.gate_outliers = false;
  EXPECT_TRUE(Validate(options).ok());
  EXPECT_FALSE(EffectiveStaticPoints(options).compensate);
  EXPECT_FALSE(EffectiveStaticPoints(options).per_point_covariance);
  EXPECT_FALSE(EffectivePoseGraph(options).gate_outliers);
}

TEST(LocalizerOptionsTest, FieldsThatDependOnOneAnotherAreHeldTogether) {
  LocalizerOptions options;
  options.static_points.max_range_m = 0.5;
  EXPECT_THAT(std::string(Validate(options).message()), StartsWith("static_points.max_range_m"));
  options = {};
  options.tracking.dead_reckoning_timeout = std::chrono::milliseconds(100);
  EXPECT_THAT(std::string(Validate(options).message()),
              StartsWith("tracking.dead_reckoning_timeout_ms"));
}

}  // namespace
}  // namespace dcloc
