#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <variant>

#include "core/localizer/localizer_options.h"

namespace dcloc {
namespace {

using ::testing::StartsWith;

// Sets a field to a number; a duration to so many milliseconds. False where it cannot hold it.
template <typename Options>
bool Set(Options& options, const OptionField<Options>& field, double value) {
  return std::visit(
      [&](auto pointer) {
        auto& member = options.*pointer;
        using Member = std::remove_reference_t<decltype(member)>;
        if constexpr (!std::is_same_v<Member, double>) {
          if (std::isnan(value)) return false;
        }
        if constexpr (std::is_same_v<Member, std::chrono::nanoseconds>) {
          member = std::chrono::milliseconds(static_cast<int>(value));
        } else {
          member = static_cast<Member>(value);
        }
        return true;
      },
      field.member);
}

template <typename Options>
class StageOptionsTest : public ::testing::Test {};

using AllOptions =
    ::testing::Types<EgoVelocityOptions, EgoMotionOptions, NoiseScaleOptions, BetaMonitorOptions,
                     MotionOptions, OdometryErrorFilterOptions, StaticPointsOptions,
                     RegistrationScheduleOptions, GicpOptions, RegistrationGate, MapMatcherOptions,
                     PosePriorOptions, GlobalLocalizerOptions, RegistrationFactorOptions,
                     PoseGraphOptions, TrackingOptions, UnobservedSigmas, LocalizerOptions>;
TYPED_TEST_SUITE(StageOptionsTest, AllOptions);

TYPED_TEST(StageOptionsTest, DefaultsAreValid) { EXPECT_TRUE(Validate(TypeParam()).ok()); }

TYPED_TEST(StageOptionsTest, EachFieldIsNamedWhereItMeansNothing) {
  for (const OptionField<TypeParam>& field : FieldsOf(TypeParam())) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), -1.0}) {
      TypeParam options;
      if (!Set(options, field, value)) continue;
      EXPECT_THAT(std::string(Validate(options).message()), StartsWith(field.name)) << value;
    }
    TypeParam options;
    ASSERT_TRUE(Set(options, field, 0.0));
    const std::string message(ValidateFields(options, FieldsOf(options)).message());
    if (field.min > 0.0) {
      EXPECT_THAT(message, StartsWith(field.name));
    } else {
      EXPECT_EQ(message, "");
      EXPECT_STRNE(field.zero, "") << field.name << ": say what zero means";
    }
  }
}

TEST(LocalizerOptionsTest, NamesAFieldByItsStage) {
  LocalizerOptions options;
  options.ego_motion.motion.correlation_time = -std::chrono::seconds(1);
  EXPECT_EQ(Validate(options).message(),
            "ego_motion.motion.correlation_time_ms is -1000; it must lie in [1, 1e+06]");
}

TEST(LocalizerOptionsTest, FieldsThatDependOnOneAnotherAreHeldTogether) {
  LocalizerOptions options;
  options.static_points.max_range_m = 0.5;
  EXPECT_THAT(std::string(Validate(options).message()), StartsWith("static_points.max_range_m"));
  options = {};
  options.tracking.lost_after = std::chrono::milliseconds(100);
  EXPECT_THAT(std::string(Validate(options).message()), StartsWith("tracking.lost_after_ms"));
}

}  // namespace
}  // namespace dcloc
