#include <algorithm>

#include "core/geometry/covariance.h"
#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

using std::chrono::milliseconds;

// What becomes of a session whose scans come so.
struct Outcome {
  int refused = 0;
  int wrong = 0;     // called tracking, and more than two metres off
  int tracking = 0;  // and right
  double last_error_m = 0.0;
};

class LocalizerTimeTest : public OnARoad {
 protected:
  static Localizer Started() {
    return MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02));
  }

  static Outcome Run(const std::vector<TrueScan>& scans) {
    Localizer localizer = Started();
    Outcome outcome;
    for (const TrueScan& seen : scans) {
      const auto answer = localizer.Localize(seen.scan);
      if (!answer.ok()) {
        ++outcome.refused;
        continue;
      }
      EXPECT_EQ(answer->stamp, seen.scan.stamp);
      outcome.last_error_m =
          (answer->T_map_vehicle.translation_m - seen.T_map_vehicle.translation_m).norm();
      if (answer->state != LocalizationState::kTracking) continue;
      outcome.last_error_m > 2.0 ? ++outcome.wrong : ++outcome.tracking;
    }
    return outcome;
  }
};

TEST_F(LocalizerTimeTest, AScanThatIsSentTwiceIsAnsweredTwiceAndUsedOnce) {
  Localizer once = Started();
  Localizer twice = Started();
  for (const TrueScan& seen : drive_) {
    const auto expected = once.Localize(seen.scan);
    ASSERT_TRUE(expected.ok());
    for (int i = 0; i < 2; ++i) {
      const auto answer = twice.Localize(seen.scan);
      ASSERT_TRUE(answer.ok()) << answer.status();
      ExpectSame(*answer, *expected);
    }
  }
}

TEST_F(LocalizerTimeTest, ScansInAnyOrderWithinAQuarterOfASecondAreUsed) {
  std::vector<TrueScan> mixed = drive_;
  for (std::size_t i = 0; i + 3 <= mixed.size(); i += 3) std::swap(mixed[i], mixed[i + 2]);
  const Outcome outcome = Run(mixed);
  EXPECT_EQ(outcome.refused, 0);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GT(outcome.tracking, static_cast<int>(drive_.size()) * 8 / 10);
  EXPECT_LT(outcome.last_error_m, 0.3);
}

// The newest scan is always that of the radar that is wrong; those of the others are late.
TEST_F(LocalizerTimeTest, LateScansTellThatAnotherRadarDoesNotFit) {
  Rig rig = FrontRadar();
  for (const char* id : {"second", "third"}) {
    rig.radars.push_back(rig.radars[0]);
    rig.radars.back().id = id;
  }
  Localizer localizer = MakeLocalizer(map_, rig, PriorAt(Start(), 0.3, 0.02));
  int unused_count = 0;
  int tracking_count = 0;
  for (std::size_t i = 0; i + 3 <= drive_.size(); i += 3) {
    for (const std::size_t later : {2, 0, 1}) {
      Scan scan = drive_[i + later].scan;
      scan.radar_id = rig.radars[later].id;
      if (later == 2 && i > drive_.size() / 2) {
        for (float& range_m : scan.range_m) range_m += 3.7F;
      }
      const auto answer = localizer.Localize(scan);
      ASSERT_TRUE(answer.ok()) << answer.status();
      if (answer->health.radars[2].fault == SourceFault::kMap) ++unused_count;
      if (answer->state == LocalizationState::kTracking) ++tracking_count;
    }
  }
  EXPECT_GT(unused_count, static_cast<int>(drive_.size()) / 4);
  EXPECT_GT(tracking_count, static_cast<int>(drive_.size()) / 2);
}

TEST_F(LocalizerTimeTest, AClockThatIsSetCostsTwoScans) {
  for (const auto by : {milliseconds(-5000), milliseconds(-600'000)}) {
    std::vector<TrueScan> set = drive_;
    for (std::size_t i = set.size() / 2; i < set.size(); ++i) set[i].scan.stamp += by;
    const Outcome outcome = Run(set);
    EXPECT_EQ(outcome.refused, 2);
    EXPECT_EQ(outcome.wrong, 0);
    EXPECT_LT(outcome.last_error_m, 0.3);
  }
}

TEST_F(LocalizerTimeTest, ASmallStepOfTheOnlyClockIsSeenByTheMap) {
  for (const auto by : {milliseconds(-200), milliseconds(200)}) {
    std::vector<TrueScan> set = drive_;
    for (std::size_t i = set.size() / 2; i < set.size(); ++i) set[i].scan.stamp += by;
    Localizer localizer = Started();
    for (const TrueScan& seen : set) {
      const auto answer = localizer.Localize(seen.scan);
      ASSERT_TRUE(answer.ok()) << answer.status();
      if (answer->state != LocalizationState::kTracking) continue;
      const double error_m =
          (answer->T_map_vehicle.translation_m - seen.T_map_vehicle.translation_m).norm();
      EXPECT_LT(error_m, 0.5);
      EXPECT_LE(error_m, answer->protection_level_m.value_or(0.0));
    }
  }
}

TEST_F(LocalizerTimeTest, LevelsHoldWhereStampsAreRounded) {
  std::vector<TrueScan> rounded = drive_;
  for (std::size_t i = rounded.size() / 3; i < rounded.size(); ++i) {
    Stamp& stamp = rounded[i].scan.stamp;
    stamp =
        Stamp((stamp.time_since_epoch() + milliseconds(25)) / milliseconds(50) * milliseconds(50));
  }
  Localizer localizer = Started();
  double worst_m = 0.0;
  for (const TrueScan& seen : rounded) {
    const auto answer = localizer.Localize(seen.scan);
    ASSERT_TRUE(answer.ok()) << answer.status();
    if (!answer->protection_level_m) continue;
    const double error_m =
        (answer->T_map_vehicle.translation_m - seen.T_map_vehicle.translation_m).norm();
    worst_m = std::max(worst_m, error_m);
    EXPECT_LE(error_m, *answer->protection_level_m);
  }
  EXPECT_GT(worst_m, 0.2) << "rounding matters";
}

TEST_F(LocalizerTimeTest, AnotherClockOfOneRadarCostsNothing) {
  Rig rig = FrontRadar();
  for (const char* id : {"second", "third"}) {
    rig.radars.push_back(rig.radars[0]);
    rig.radars.back().id = id;
  }
  for (const auto off : {milliseconds(200), milliseconds(-200), milliseconds(400),
                         milliseconds(5000), milliseconds(-5000)}) {
    Localizer localizer = MakeLocalizer(map_, rig, PriorAt(Start(), 0.3, 0.02));
    int wrong = 0;
    int tracking = 0;
    Health health;
    for (std::size_t i = 0; i < drive_.size(); ++i) {
      Scan scan = drive_[i].scan;
      scan.radar_id = rig.radars[i % 3].id;
      if (i % 3 == 1 && i > drive_.size() / 4) scan.stamp += off;
      const auto answer = localizer.Localize(scan);
      if (!answer.ok()) continue;
      EXPECT_EQ(answer->stamp, scan.stamp);
      health = answer->health;
      if (answer->state != LocalizationState::kTracking) continue;
      const Eigen::Vector3d error_m =
          answer->T_map_vehicle.translation_m - drive_[i].T_map_vehicle.translation_m;
      error_m.norm() > 2.0 ? ++wrong : ++tracking;
    }
    EXPECT_LE(wrong, 4) << "until it is known";
    EXPECT_GT(tracking, static_cast<int>(drive_.size()) * 7 / 10) << off.count();
    EXPECT_EQ(health.radars[1].fault, SourceFault::kClock);
    EXPECT_EQ(health.radars[0].fault, SourceFault::kNone);
  }
}

// The first scan after it may be of a clock that leapt, or of a vehicle that went on.
TEST_F(LocalizerTimeTest, NothingIsClaimedOfTheFirstScanAfterASilenceOfAllRadars) {
  Rig rig = FrontRadar();
  rig.radars.push_back(rig.radars[0]);
  rig.radars[1].id = "second";
  std::vector<TrueScan> drive = drive_;
  const std::size_t gap_at = 50;
  drive.erase(drive.begin() + gap_at, drive.begin() + gap_at + 26);  // 2 s
  Localizer localizer = MakeLocalizer(map_, rig, PriorAt(Start(), 0.3, 0.02));
  double worst_m = 0.0;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    Scan scan = drive[i].scan;
    scan.radar_id = rig.radars[i % 2].id;
    const auto answer = localizer.Localize(scan);
    ASSERT_TRUE(answer.ok());
    const Eigen::Vector3d error_m =
        answer->T_map_vehicle.translation_m - drive[i].T_map_vehicle.translation_m;
    worst_m = std::max(worst_m, error_m.norm());
    EXPECT_LE(error_m.norm(), 4.0 * HorizontalSigma(answer->covariance)) << i;
    if (answer->state != LocalizationState::kTracking) continue;
    EXPECT_LE(error_m.norm(), 2.0) << i;
  }
  EXPECT_GT(worst_m, 10.0) << "it is answered where the vehicle was before";
}

// Its stamps leap by less than the scans that are missing. No place that they are held against is
// where the vehicle is.
TEST_F(LocalizerTimeTest, TheClockOfAVehicleThatWasCarriedIsNotCorrected) {
  for (const auto step : {milliseconds(-45), milliseconds(45)}) {
    std::vector<TrueScan> drive = drive_;
    const std::size_t gone = 36;
    const auto at = drive.begin() + 50;
    drive.erase(at, at + gone);
    for (std::size_t i = 50; i < drive.size(); ++i) {
      drive[i].scan.stamp -= milliseconds(77 * gone) - step;
    }
    Localizer localizer = Started();
    Health health;
    for (const TrueScan& seen : drive) {
      const auto answer = localizer.Localize(seen.scan);
      ASSERT_TRUE(answer.ok());
      health = answer->health;
    }
    EXPECT_EQ(health.radars[0].fault, SourceFault::kNone) << step.count();
  }
}

TEST_F(LocalizerTimeTest, ARadarThatFallsSilentLeavesTheSubmap) {
  Rig rig = FrontRadar();
  rig.radars.push_back(rig.radars[0]);
  rig.radars[1].id = "second";
  Localizer localizer = MakeLocalizer(map_, rig, PriorAt(Start(), 0.3, 0.02));
  int most = 0;
  int last = 0;
  for (std::size_t i = 0; i < drive_.size(); ++i) {
    Scan scan = drive_[i].scan;
    if (i < 40 && i % 2 == 1) scan.radar_id = "second";
    const auto answer = localizer.Localize(scan);
    ASSERT_TRUE(answer.ok());
    last = answer->quality.live_point_count;
    most = std::max(most, last);
  }
  Localizer alone = Started();
  int expected = 0;
  for (const TrueScan& seen : drive_) {
    expected = alone.Localize(seen.scan)->quality.live_point_count;
  }
  EXPECT_GT(most, expected);
  EXPECT_EQ(last, expected);
}

constexpr double kLateSpeed_mps = 15.0;
constexpr int kLate_ms = 100;

class LocalizerStampsTest : public ::testing::Test {
 protected:
  std::shared_ptr<const RadarMap> MapWith(double time_offset_sigma_s) const {
    Rig rig = FrontRadar();
    rig.radars[0].time_offset_sigma_s = time_offset_sigma_s;
    return MapOfDrive(DriveRoad(world_, rig, 10.0, 1), rig);
  }

  // By a radar whose stamps are late by kLate_ms.
  std::vector<TrueAnswer> Localize(const std::shared_ptr<const RadarMap>& map,
                                   const LocalizerOptions& options) const {
    std::vector<TrueScan> drive = DriveRoad(world_, FrontRadar(), kLateSpeed_mps, 2);
    for (std::size_t i = 0; i < drive.size(); ++i) {
      drive[i].scan.stamp += std::chrono::milliseconds(kLate_ms);
      drive[i].T_map_vehicle = SyntheticWorld::OnRoad(
          kLateSpeed_mps * (0.077 * static_cast<double>(i) + 1e-3 * kLate_ms));
    }
    const InitialPose prior = PriorAt(drive.front().T_map_vehicle, 0.5, 0.02);
    return LocalizeDrive(MakeLocalizer(map, FrontRadar(), prior, options), drive);
  }

  static LocalizerOptions Knowing(double late_s) {
    LocalizerOptions options;
    options.known.Of("front").stamp_delay = {late_s, 1e-5};
    return options;
  }

  static double MedianError_m(const std::vector<TrueAnswer>& answers) {
    std::vector<double> errors_m;
    errors_m.reserve(answers.size());
    for (const TrueAnswer& answer : answers) errors_m.push_back(answer.position_error_m());
    std::ranges::nth_element(errors_m, errors_m.begin() + std::ssize(errors_m) / 2);
    return errors_m[errors_m.size() / 2];
  }

  const SyntheticWorld world_;
};

TEST_F(LocalizerStampsTest, InAMapWithKnownStampsALateRadarIsCorrected) {
  const auto map = MapWith(0.01);
  ASSERT_TRUE(map->info().stamp_delay_s);
  EXPECT_GT(MedianError_m(Localize(map, {})), 1.0) << "before it is learned";
  EXPECT_LT(MedianError_m(Localize(map, Knowing(1e-3 * kLate_ms))), 0.2);
}

// Its radars may be as late as those of the vehicle.
TEST_F(LocalizerStampsTest, InAnyOtherMapWhatIsKnownChangesNothingAndIsHandedOn) {
  const auto map = MapWith(0.02);
  ASSERT_FALSE(map->info().stamp_delay_s);
  const std::vector<TrueAnswer> without = Localize(map, {});
  const std::vector<TrueAnswer> with = Localize(map, Knowing(1e-3 * kLate_ms));
  ASSERT_EQ(with.size(), without.size());
  bool is_told = false;
  for (std::size_t i = 0; i < with.size(); ++i) {
    ExpectSame(with[i].localization, without[i].localization);
    const std::optional<RigKnowledge>& learned = with[i].localization.learned;
    const RadarKnowledge* radar = learned ? learned->Find("front") : nullptr;
    is_told = is_told || (radar != nullptr && radar->stamp_delay);
  }
  EXPECT_TRUE(is_told);
}

TEST_F(LocalizerStampsTest, ASteadyDriveIsLocalizedAlikeInBoth) {
  const std::vector<TrueAnswer> known = Localize(MapWith(0.01), {});
  const std::vector<TrueAnswer> unknown = Localize(MapWith(0.02), {});
  ASSERT_EQ(known.size(), unknown.size());
  for (std::size_t i = 0; i < known.size(); ++i) {
    ExpectSame(known[i].localization, unknown[i].localization);
  }
}

}  // namespace
}  // namespace dcloc
