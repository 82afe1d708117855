#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr float kNanFloat = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// How a good scan is spoilt (given the scan before it), and what the error must name.
struct BadScan {
  const char* name;
  std::function<void(Scan& scan, const Scan& before)> spoil;
  const char* field;
};

const BadScan kBadScans[] = {
    {"UnknownRadar", [](Scan& scan, const Scan&) { scan.radar_id = "roof"; }, "radar_id 'roof'"},
    {"StampBefore1970",
     [](Scan& scan, const Scan&) { scan.stamp = Stamp(std::chrono::nanoseconds(-1)); }, "stamp"},
    {"StampOfAnotherAge",
     [](Scan& scan, const Scan&) { scan.stamp = Stamp(std::chrono::hours(24 * 365 * 290)); },
     "stamp"},
    {"StampGoingBack",
     [](Scan& scan, const Scan& before) { scan.stamp = before.stamp - std::chrono::hours(1); },
     "stamp"},
    {"RangeNan", [](Scan& scan, const Scan&) { scan.range_m[1] = kNanFloat; }, "range_m[1]"},
    {"RangeInfinite", [](Scan& scan, const Scan&) { scan.range_m[0] = kInfinity; }, "range_m[0]"},
    {"RangeNegative", [](Scan& scan, const Scan&) { scan.range_m[0] = -5.0F; }, "range_m[0]"},
    {"RangeRateNan", [](Scan& scan, const Scan&) { scan.range_rate_mps[2] = kNanFloat; },
     "range_rate_mps[2]"},
    {"AzimuthBeyondATurn", [](Scan& scan, const Scan&) { scan.azimuth_rad[0] = 7.0F; },
     "azimuth_rad[0]"},
    {"UnequalColumns", [](Scan& scan, const Scan&) { scan.azimuth_rad.pop_back(); },
     "azimuth_rad has"},
    {"UnequalOptionalColumn", [](Scan& scan, const Scan&) { scan.rcs_dbsm = {1.0F}; },
     "rcs_dbsm has"},
    {"SigmaZero", [](Scan& scan, const Scan&) { scan.range_sigma_m.assign(scan.size(), 0.0F); },
     "range_sigma_m[0]"},
    {"SigmaHuge", [](Scan& scan, const Scan&) { scan.range_sigma_m.assign(scan.size(), 1e30F); },
     "range_sigma_m[0]"},
    {"VelocityNan", [](Scan& scan, const Scan&) { scan.ego_velocity->linear_mps.x() = kNan; },
     "ego_velocity.linear_mps"},
    {"TurnRateTooHigh", [](Scan& scan, const Scan&) { scan.ego_velocity->angular_radps.z() = 1e6; },
     "ego_velocity.angular_radps"},
    {"VelocityCovarianceNegative",
     [](Scan& scan, const Scan&) { scan.ego_velocity->covariance = -Matrix6d::Identity(); },
     "ego_velocity.covariance"},
    {"VelocityCovarianceHuge",
     [](Scan& scan, const Scan&) { scan.ego_velocity->covariance = 1e30 * Matrix6d::Identity(); },
     "ego_velocity.covariance"},
};

class BadScanTest : public ::testing::TestWithParam<BadScan> {
 protected:
  static void SetUpTestSuite() {
    const SyntheticWorld world;
    map_ = MapOfDrive(DriveRoad(world, FrontRadar(), 8.0, 1), FrontRadar());
    drive_ = DriveRoad(world, FrontRadar(), 14.0, 2);
    drive_.resize(40);
    answers_ = LocalizeDrive(NewLocalizer(), drive_);
  }
  static void TearDownTestSuite() {
    map_.reset();
    drive_.clear();
    answers_.clear();
  }

  static Localizer NewLocalizer() {
    return MakeLocalizer(map_, FrontRadar(), PriorAt(drive_.front().T_map_vehicle, 0.3, 0.02));
  }

  static std::shared_ptr<const RadarMap> map_;
  static std::vector<TrueScan> drive_;
  static std::vector<TrueAnswer> answers_;  // of a session that never saw anything bad
};
std::shared_ptr<const RadarMap> BadScanTest::map_;
std::vector<TrueScan> BadScanTest::drive_;
std::vector<TrueAnswer> BadScanTest::answers_;

TEST_P(BadScanTest, IsRefusedByNameAndLeavesTheSessionAsItWas) {
  Localizer localizer = NewLocalizer();
  for (std::size_t i = 0; i < drive_.size(); ++i) {
    if (i > 0) {
      Scan bad = drive_[i].scan;
      GetParam().spoil(bad, drive_[i - 1].scan);
      const auto refused = localizer.Localize(bad);
      ASSERT_EQ(refused.status().code(), absl::StatusCode::kInvalidArgument) << "scan " << i;
      EXPECT_THAT(std::string(refused.status().message()), HasSubstr(GetParam().field));
    }
    const auto answer = localizer.Localize(drive_[i].scan);
    ASSERT_TRUE(answer.ok()) << answer.status();
    ExpectSame(*answer, answers_[i].localization);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, BadScanTest, ::testing::ValuesIn(kBadScans),
                         [](const auto& test) { return test.param.name; });

TEST(LocalizerStampTest, LongSilenceIsNoError) {
  const SyntheticWorld world;
  const auto map = MapOfDrive(DriveRoad(world, FrontRadar(), 8.0, 1), FrontRadar());
  auto drive = DriveRoad(world, FrontRadar(), 14.0, 2);
  drive.resize(40);
  Localizer localizer =
      MakeLocalizer(map, FrontRadar(), PriorAt(drive.front().T_map_vehicle, 0.3, 0.02));
  for (const TrueScan& seen : drive) ASSERT_TRUE(localizer.Localize(seen.scan).ok());
  Scan scan = drive.back().scan;
  scan.stamp += std::chrono::hours(24 * 365);
  const auto answer = localizer.Localize(scan);
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_TRUE(answer->T_map_vehicle.translation_m.allFinite());
  EXPECT_TRUE(IsCovariance(answer->covariance));
  EXPECT_NE(answer->state, LocalizationState::kTracking);
}

class LocalizerCreateTest : public ::testing::Test {
 protected:
  static std::string ErrorOf(const Rig& rig, const std::optional<InitialPose>& prior,
                             const LocalizerOptions& options) {
    static const auto map =
        MapOfDrive(DriveRoad(SyntheticWorld(), FrontRadar(), 8.0, 1), FrontRadar());
    const auto localizer = Localizer::Create(map, rig, prior, options);
    if (localizer.ok()) return "";
    EXPECT_EQ(localizer.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(localizer.status().message());
  }
};

TEST_F(LocalizerCreateTest, NamesWhatIsWrongWithTheStart) {
  EXPECT_EQ(ErrorOf(FrontRadar(), std::nullopt, {}), "");
  EXPECT_NE(ErrorOf({}, std::nullopt, {}), "");
  Rig rig = FrontRadar();
  rig.radars[0].range_sigma_m = -1.0;
  EXPECT_THAT(ErrorOf(rig, std::nullopt, {}), HasSubstr("range_sigma_m"));

  InitialPose prior = PriorAt({}, 0.3, 0.02);
  prior.T_map_vehicle.translation_m.y() = kNan;
  EXPECT_THAT(ErrorOf(FrontRadar(), prior, {}), HasSubstr("initial_pose.T_map_vehicle"));
  prior = PriorAt({}, 0.3, 0.02);
  prior.T_map_vehicle.rotation.coeffs() *= 3.0;
  EXPECT_THAT(ErrorOf(FrontRadar(), prior, {}), HasSubstr("initial_pose.T_map_vehicle"));
  prior = PriorAt({}, 0.3, 0.02);
  prior.covariance(2, 2) = -1.0;
  EXPECT_THAT(ErrorOf(FrontRadar(), prior, {}), HasSubstr("initial_pose.covariance"));
  prior.covariance(2, 2) = kNan;
  EXPECT_THAT(ErrorOf(FrontRadar(), prior, {}), HasSubstr("initial_pose.covariance"));
}

TEST_F(LocalizerCreateTest, NamesOptionsOutOfRange) {
  LocalizerOptions options;
  options.matcher.gicp.max_correspondence_distance_m = -2.0;
  EXPECT_EQ(ErrorOf(FrontRadar(), std::nullopt, options),
            "matcher.gicp.max_correspondence_distance_m is -2; it must lie in [0.1, 20]");
}

TEST_F(LocalizerCreateTest, NamesAMapThatIsNotThere) {
  const auto localizer = Localizer::Create(nullptr, FrontRadar(), std::nullopt);
  EXPECT_EQ(localizer.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(localizer.status().message()), HasSubstr("map"));
}

}  // namespace
}  // namespace dcloc
