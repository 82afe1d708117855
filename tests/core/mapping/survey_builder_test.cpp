#include "core/mapping/survey_builder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/map/radar_map.h"
#include "tests/core/mapping/ring_road.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

struct MemoryDrive {
  std::string name;
  Rig rig;
  std::vector<Scan> scans;
};

class MemoryReader final : public DriveReader {
 public:
  explicit MemoryReader(const MemoryDrive& drive) : drive_(drive) {}
  const std::string& name() const override { return drive_.name; }
  const Rig& rig() const override { return drive_.rig; }
  std::size_t scan_count() const override { return drive_.scans.size(); }
  absl::StatusOr<const Scan*> Next() override {
    return next_ == drive_.scans.size() ? nullptr : &drive_.scans[next_++];
  }

 private:
  const MemoryDrive& drive_;
  std::size_t next_ = 0;
};

class MemoryDrives final : public DriveSource {
 public:
  std::size_t drive_count() const override { return drives.size(); }
  absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t drive) override {
    ++opened_count;
    return std::make_unique<MemoryReader>(drives[drive]);
  }

  std::vector<MemoryDrive> drives;
  int opened_count = 0;
};

MemoryDrive Around(const std::string& name, double begin_m, double length_m, double speed_mps,
                   unsigned seed) {
  MemoryDrive drive{.name = name, .rig = FrontRadar(), .scans = {}};
  for (RingScan& entry : ScansOnRing(RingRoad(2), begin_m, length_m, speed_mps, seed)) {
    drive.scans.push_back(std::move(entry.scan));
  }
  return drive;
}

/// Two drives over the same ground; `length_m` is the second one's.
std::vector<MemoryDrive> TwoDrives(double length_m = 250.0) {
  return {Around("a", 0.0, 620.0, 12.0, 2), Around("b", 300.0, length_m, 15.0, 3)};
}

/// Calibrates once, by few returns.
SurveyBuilderOptions Quickly() {
  SurveyBuilderOptions options;
  options.calibrator.max_returns = 4000;
  options.calibration_rounds = 1;
  return options;
}

bool KeepGoing(const char* /*stage*/, double /*share*/) { return true; }

TEST(SurveyBuilderTest, MakesAMapOfDrivesReadingEachTwice) {
  MemoryDrives source;
  source.drives = TwoDrives();
  SurveyBuilder builder(source, KeepGoing);
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  ASSERT_TRUE(builder.survey().drives[1].is_in_map) << builder.survey().drives[1].reason;
  const auto bytes = builder.Fuse({.name = "road"});
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_EQ(source.opened_count, 4);
  const auto map = RadarMap::FromBytes(*bytes);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ((*map)->info().name, "road");
  EXPECT_GT((*map)->info().point_count, 50U);
  EXPECT_EQ(*builder.Fuse({.name = "road"}), *bytes) << "the same drives, the same bytes";
}

// The ring's scatterers stand at the radar's height, and its wheels are right.
TEST(SurveyBuilderTest, AScaleThatIsRightIsLeft) {
  MemoryDrives source;
  source.drives = TwoDrives(620.0);
  SurveyBuilderOptions options;
  options.scale.min_visit_count = 5;
  SurveyBuilder builder(source, KeepGoing, options);
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  const Pose2 before = builder.survey().drives[0].T_map_nodes.back();
  ASSERT_TRUE(builder.CorrectScale().ok());
  ASSERT_TRUE(builder.scale_correction().has_value());
  const double shift_m =
      (builder.survey().drives[0].T_map_nodes.back().translation_m - before.translation_m).norm();
  EXPECT_LT(shift_m, 0.01 * before.translation_m.norm());
  EXPECT_NEAR(builder.scale_correction()->value, 0.0,
              4.0 * std::sqrt(builder.scale_correction()->variance));
}

TEST(SurveyBuilderTest, AStopWhileTheScaleIsMeasuredEndsIt) {
  MemoryDrives source;
  source.drives = TwoDrives();
  bool is_stopped = false;
  SurveyBuilder builder(source, [&](const char* stage, double /*share*/) {
    is_stopped = is_stopped || std::string_view(stage).starts_with("measuring the scale");
    return !is_stopped;
  });
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  EXPECT_EQ(builder.CorrectScale().code(), absl::StatusCode::kCancelled);
}

TEST(SurveyBuilderTest, ADriveThatIsLeftOutIsNotReadAgain) {
  MemoryDrives source;
  source.drives = TwoDrives(5.0);
  SurveyBuilder builder(source, KeepGoing);
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  EXPECT_FALSE(builder.survey().drives[1].is_in_map);
  ASSERT_TRUE(builder.Fuse({}).ok());
  EXPECT_EQ(source.opened_count, 3);
}

TEST(SurveyBuilderTest, AScanThatIsWrongIsNamed) {
  MemoryDrives source;
  source.drives = TwoDrives();
  source.drives[1].scans[7].radar_id = "rear";
  const absl::Status status = SurveyBuilder(source, KeepGoing).Track();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("b, scan 7: "));
}

/// A drive around the ring with a radar ahead and one that looks aside, described `yaw_error_rad`
/// from where it looks.
MemoryDrive WithTwoRadars(double yaw_error_rad) {
  Rig rig = FrontRadar();
  rig.radars.push_back(rig.radars[0]);
  rig.radars[1].id = "side";
  rig.radars[1].T_vehicle_radar.rotation = Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitZ());
  MemoryDrive drive{.name = "a", .rig = rig, .scans = {}};
  const SyntheticWorld world = RingRoad(2);
  std::mt19937 random(4);
  for (int i = 0; i < 250; ++i) {
    const Stamp stamp(std::chrono::seconds(1'700'000'000) + std::chrono::milliseconds(77 * i));
    const EgoVelocity ego{.linear_mps = {12.0, 0.0, 0.0},
                          .angular_radps = {0.0, 0.0, 12.0 / kRingRadius_m}};
    for (const RadarModel& radar : rig.radars) {
      Scan scan = world.See(radar, OnRing(0.077 * 12.0 * i), ego, stamp, random);
      scan.ego_velocity = ego;
      drive.scans.push_back(std::move(scan));
    }
  }
  drive.rig.radars[1].T_vehicle_radar.rotation =
      Eigen::AngleAxisd(0.9 + yaw_error_rad, Eigen::Vector3d::UnitZ());
  return drive;
}

double YawOf(const SurveyBuilder& builder, std::size_t radar) {
  return builder.calibrations()[radar].of(CalibrationParameter::kMountYaw).applied;
}

TEST(SurveyBuilderTest, CalibratesMountsByItsOwnPoses) {
  MemoryDrives source;
  source.drives = {WithTwoRadars(0.03)};
  SurveyBuilder builder(source, KeepGoing, Quickly());
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  ASSERT_TRUE(builder.Calibrate({}).ok());
  ASSERT_EQ(builder.calibrations().size(), 2U);
  EXPECT_NEAR(YawOf(builder, 1) - YawOf(builder, 0), -0.03, 0.01);
  EXPECT_TRUE(builder.survey().drives[0].is_in_map);
  EXPECT_TRUE(builder.Fuse({.name = "road"}).ok());
}

TEST(SurveyBuilderTest, LeavesRadarsThatAreDescribedRightAlone) {
  MemoryDrives source;
  source.drives = {WithTwoRadars(0.0)};
  SurveyBuilder builder(source, KeepGoing, Quickly());
  ASSERT_TRUE(builder.Track().ok());
  ASSERT_TRUE(builder.Place({}).ok());
  ASSERT_TRUE(builder.Calibrate({}).ok());
  EXPECT_NEAR(YawOf(builder, 0), 0.0, 0.003);
  EXPECT_NEAR(YawOf(builder, 1), 0.0, 0.003);
}

TEST(SurveyBuilderTest, EachStageCanBeStopped) {
  for (const std::string stage :
       {"tracking b (2 of 2)", "calibrating by a", "estimating mounts and clocks",
        "placing scans of b", "fusing landmarks"}) {
    MemoryDrives source;
    source.drives = TwoDrives();
    bool seen = false;
    SurveyBuilder builder(
        source,
        [&](const char* at, double share) {
          EXPECT_GE(share, 0.0);
          EXPECT_LE(share, 1.0);
          seen = seen || stage == at;
          return stage != at;
        },
        Quickly());
    absl::Status status = builder.Track();
    if (status.ok()) status = builder.Place({});
    if (status.ok()) status = builder.Calibrate({});
    if (status.ok()) status = builder.Fuse({}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kCancelled) << stage;
    EXPECT_TRUE(seen) << stage;
  }
}

}  // namespace
}  // namespace dcloc
