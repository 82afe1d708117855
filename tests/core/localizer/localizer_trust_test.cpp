#include <functional>

#include "core/map/editable_map.h"
#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

// What a vehicle says of its motion, and how it is wrong.
struct Lie {
  const char* name;
  std::function<void(EgoVelocity& reported)> report;
};

const Lie kLies[] = {
    {"Standing", [](EgoVelocity& v) { v.linear_mps.setZero(); }},
    {"Backwards", [](EgoVelocity& v) { v.linear_mps *= -1.0; }},
    {"HalfAsFast", [](EgoVelocity& v) { v.linear_mps *= 0.5; }},
    {"AThirdFaster", [](EgoVelocity& v) { v.linear_mps *= 1.3; }},
    {"Turning", [](EgoVelocity& v) { v.angular_radps.z() += 5.0 * kDegree; }},
    {"AndSureOfIt",
     [](EgoVelocity& v) {
       v.linear_mps *= 1.3;
       v.covariance = 1e-8 * Matrix6d::Identity();
     }},
};

class LyingOdometryTest : public OnARoad, public ::testing::WithParamInterface<Lie> {};

TEST_P(LyingOdometryTest, FromSomeMomentOnMisleadsNobody) {
  std::vector<TrueScan> drive = drive_;
  for (std::size_t i = drive.size() / 3; i < drive.size(); ++i) {
    GetParam().report(*drive[i].scan.ego_velocity);
  }
  const Errors errors = ErrorsOf(
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive));
  EXPECT_LT(errors.max_m, 2.0);
  EXPECT_LT(errors.max_rad, 5.0 * kDegree);
  EXPECT_GT(errors.tracking_count, static_cast<int>(drive.size()) / 2);
}

TEST_P(LyingOdometryTest, FromTheStartMisleadsNobody) {
  std::vector<TrueScan> drive = drive_;
  for (TrueScan& seen : drive) GetParam().report(*seen.scan.ego_velocity);
  const Errors errors = ErrorsOf(
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive));
  EXPECT_LT(errors.max_m, 2.0);
  EXPECT_LT(errors.max_rad, 5.0 * kDegree);
}

INSTANTIATE_TEST_SUITE_P(Lies, LyingOdometryTest, ::testing::ValuesIn(kLies),
                         [](const auto& test) { return std::string(test.param.name); });

// A radar that counts its azimuths clockwise sees the mirror image of the road.
TEST_F(OnARoad, ARadarWhoseAzimuthsAreMirroredTracksAllTheSame) {
  std::vector<TrueScan> drive = drive_;
  for (TrueScan& seen : drive) {
    for (float& azimuth_rad : seen.scan.azimuth_rad) azimuth_rad = -azimuth_rad;
  }
  const std::vector<TrueAnswer> answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive);
  const Errors errors = ErrorsOf(answers);
  EXPECT_LT(errors.max_m, 0.5);
  EXPECT_GT(errors.tracking_count, static_cast<int>(drive.size()) * 3 / 4);
}

// A pose absorbs nearly all of it: the radar looks ahead.
TEST_F(OnARoad, ARadarWhoseRangesAreTooLongIsCorrectedAndToldOf) {
  std::vector<TrueScan> drive = drive_;
  for (TrueScan& seen : drive) {
    for (float& range_m : seen.scan.range_m) range_m += 1.0F;
  }
  const std::vector<TrueAnswer> answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive);
  std::optional<RigKnowledge> known;
  for (const TrueAnswer& answer : answers) {
    if (answer.localization.protection_level_m) {
      EXPECT_LT(answer.position_error_m(), *answer.localization.protection_level_m);
    }
    if (answer.localization.learned) known = answer.localization.learned;
  }
  EXPECT_TRUE(answers.back().tracking());
  EXPECT_LT(answers.back().position_error_m(), 0.3);
  EXPECT_EQ(answers.back().localization.health.radars[0].fault, SourceFault::kMount);
  ASSERT_TRUE(known);
  const RadarKnowledge* radar = known->Find("front");
  ASSERT_NE(radar, nullptr);
  ASSERT_TRUE(radar->range_bias_error);
  EXPECT_NEAR(radar->range_bias_error->value, 1.0, 0.2);

  LocalizerOptions options;
  options.known = *known;
  const Errors errors = ErrorsOf(LocalizeDrive(
      MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02), options), drive));
  EXPECT_LT(errors.max_m, 0.3) << "by the session after it";
}

// Its buffer is not filled any more: the same three scans come again and again, under new stamps.
TEST_F(OnARoad, ARadarThatRepeatsItsScansIsNotBelievedAndTrackedWithOnceItSeesAgain) {
  std::vector<TrueScan> drive = drive_;
  const std::size_t begin = drive.size() / 3;
  const std::size_t end = 2 * drive.size() / 3;
  for (std::size_t i = begin; i < end; ++i) {
    const Scan& old = drive_[begin - 3 + i % 3].scan;
    Scan& scan = drive[i].scan;
    scan.range_m = old.range_m;
    scan.range_rate_mps = old.range_rate_mps;
    scan.azimuth_rad = old.azimuth_rad;
  }
  const std::vector<TrueAnswer> answers =
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive);
  constexpr std::size_t kHeld = 6;  // scans
  for (std::size_t i = begin + kHeld; i < end; ++i) {
    const SourceHealth& radar = answers[i].localization.health.radars[0];
    EXPECT_EQ(radar.fault, SourceFault::kFrozen) << i;
    EXPECT_FALSE(radar.is_used) << i;
    EXPECT_EQ(answers[i].tracking(), false) << i;
  }
  const Errors errors = ErrorsOf(answers);
  EXPECT_LT(errors.max_m, 1.0);
  EXPECT_EQ(answers[end].localization.health.radars[0].fault, SourceFault::kNone);
  EXPECT_TRUE(answers[end + 20].tracking());
}

class WrongPlaceTest : public OnARoad {
 protected:
  // Answers that are called tracking and are not right; and whether the last one is right.
  static void ExpectNeverWrongAndFound(const std::vector<TrueAnswer>& answers) {
    for (const TrueAnswer& answer : answers) {
      if (!answer.tracking()) continue;
      EXPECT_LT(answer.position_error_m(), 2.0);
      EXPECT_LT(answer.yaw_error_rad(), 5.0 * kDegree);
    }
    EXPECT_TRUE(answers.back().tracking());
  }
};

TEST_F(WrongPlaceTest, APriorThatIsWrongAndSureOfItIsLeft) {
  const Pose2 kWrong[] = {{{6.0, 0.0}, 0.0}, {{20.0, 0.0}, 0.0}, {{0.0, 0.0}, 3.14}};
  for (const Pose2& wrong : kWrong) {
    SCOPED_TRACE(wrong.translation_m.x());
    const InitialPose prior = PriorAt(Start() * Embed(wrong), 0.5, 0.02);
    ExpectNeverWrongAndFound(LocalizeDrive(MakeLocalizer(map_, FrontRadar(), prior), drive_));
  }
}

// The road is there as mapped, and what stands beside it is another: its mirror image.
TEST_F(WrongPlaceTest, InTheMapOfAnotherStreetNothingIsTracking) {
  EditableMap other = ToEditable(*map_);
  for (EditableKeyframe& keyframe : other.keyframes) {
    for (MapPoint& point : keyframe.points) {
      point.y_m = -point.y_m;
      point.xy_m2 = -point.xy_m2;
      point.yz_m2 = -point.yz_m2;
    }
  }
  const auto map = RadarMap::FromBytes(*ToMapBytes(other));
  ASSERT_TRUE(map.ok());
  const InitialPose prior = PriorAt(Start(), 0.3, 0.02);
  EXPECT_EQ(
      ErrorsOf(LocalizeDrive(MakeLocalizer(*map, FrontRadar(), prior), drive_)).tracking_count, 0);
}

TEST_F(WrongPlaceTest, AVehicleThatWasCarriedIsFoundAgain) {
  // Forty metres are missing; the clock and the wheels say nothing of it.
  std::vector<TrueScan> drive = drive_;
  const std::size_t gone = 36;
  const auto at = drive.begin() + 50;
  drive.erase(at, at + gone);
  for (std::size_t i = 50; i < drive.size(); ++i) {
    drive[i].scan.stamp -= std::chrono::milliseconds(77 * gone);
  }
  ExpectNeverWrongAndFound(
      LocalizeDrive(MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.3, 0.02)), drive));
}

}  // namespace
}  // namespace dcloc
