#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/trajectory/decimal_stamp.h"
#include "client/trajectory/file_of_drive.h"
#include "client/trajectory/trajectory_error.h"
#include "client/trajectory/trajectory_reader.h"
#include "client/trajectory/trajectory_writer.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

Stamp At_ns(std::int64_t nanoseconds) { return Stamp(std::chrono::nanoseconds(nanoseconds)); }

/// Two poses a second apart, at stamps that no double holds.
Trajectory Two() {
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()));
  return {.name = "a <b> & c",
          .anchor = std::nullopt,
          .poses = {{At_ns(1'714'557'600'000'000'001), {{1.0 / 3.0, 2.0, 0.1}, turned}},
                    {At_ns(1'714'557'601'000'000'002), {{4.0 / 3.0, 2.0, 0.1}, turned}}}};
}

Trajectory OnEarth() {
  Trajectory trajectory = Two();
  trajectory.anchor = GeodeticAnchor{.origin = {.latitude_deg = 48.1, .longitude_deg = 11.6}};
  return trajectory;
}

void ExpectSamePoses(const Trajectory& a, const Trajectory& b) {
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].stamp, b.poses[i].stamp);
    EXPECT_EQ(a.poses[i].T_map_vehicle.translation_m, b.poses[i].T_map_vehicle.translation_m);
    EXPECT_NEAR(
        a.poses[i].T_map_vehicle.rotation.angularDistance(b.poses[i].T_map_vehicle.rotation), 0.0,
        1e-15);
  }
}

TEST(FileOfDriveTest, LiesBesideTheFileWhateverTheDriveIsNamed) {
  EXPECT_EQ(FileOfDrive("out.1/way.tum", "monday/north"), "out.1/way-monday%2Fnorth.tum");
  EXPECT_EQ(FileOfDrive("way", "../up"), "way-..%2Fup");
}

TEST(FileOfDriveTest, TwoDrivesNeverHaveOneFile) {
  const std::vector<std::string> drives = {"a/b", "a_b", "a%2Fb", "a%252Fb",
                                           "a-b", "a%b", "/",     "%"};
  std::set<std::filesystem::path> files;
  for (const std::string& drive : drives) files.insert(FileOfDrive("way.tum", drive));
  EXPECT_EQ(files.size(), drives.size());
}

TEST(DecimalStampTest, KeepsEveryNanosecond) {
  const auto count = [](absl::string_view text) {
    const std::optional<Stamp> stamp = StampOfSeconds(text);
    return stamp ? stamp->time_since_epoch().count() : -1;
  };
  EXPECT_EQ(count("1706001762.429354169"), 1'706'001'762'429'354'169);
  EXPECT_EQ(count("1706001762.5"), 1'706'001'762'500'000'000);
  EXPECT_EQ(count("1.5e9"), 1'500'000'000'000'000'000);
  EXPECT_EQ(count("-1"), -1);
  EXPECT_EQ(count("soon"), -1);
}

TEST(TrajectoryTest, TumAndCsvComeBackAsTheyWere) {
  for (const TrajectoryFormat format : {TrajectoryFormat::kTum, TrajectoryFormat::kCsv}) {
    const auto text = FormatTrajectory(Two(), format);
    ASSERT_TRUE(text.ok()) << text.status();
    const auto read = ParseTrajectory(*text, format, "file");
    ASSERT_TRUE(read.ok()) << read.status();
    ExpectSamePoses(*read, Two());
  }
}

TEST(TrajectoryTest, KittiHasTwelveNumbersALine) {
  const auto text = FormatTrajectory(Two(), TrajectoryFormat::kKitti);
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(std::count(text->begin(), text->end(), '\n'), 2);
  EXPECT_EQ(std::count(text->begin(), text->end(), ' '), 2 * 11);
}

TEST(TrajectoryTest, GeoJsonAndGpxHaveThePlaceOnTheEarth) {
  const auto text = FormatTrajectory(OnEarth(), TrajectoryFormat::kGeoJson);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto json = nlohmann::json::parse(*text);
  const auto& geometry = json["features"][0]["geometry"];
  EXPECT_EQ(geometry["type"], "LineString");
  EXPECT_NEAR(geometry["coordinates"][0][0].get<double>(), 11.6, 1e-4);
  EXPECT_NEAR(geometry["coordinates"][0][1].get<double>(), 48.1, 1e-4);
  EXPECT_EQ(json["features"][0]["properties"]["coordTimes"][0], "2024-05-01T10:00:00.000000001Z");
  const auto gpx = FormatTrajectory(OnEarth(), TrajectoryFormat::kGpx);
  ASSERT_TRUE(gpx.ok()) << gpx.status();
  EXPECT_THAT(*gpx, HasSubstr("<name>a &lt;b&gt; &amp; c</name>"));
  EXPECT_THAT(*gpx, HasSubstr("<trkpt lat=\"48.1000"));
}

TEST(TrajectoryTest, WithoutAnAnchorThereIsNoPlaceOnTheEarth) {
  EXPECT_EQ(FormatTrajectory(Two(), TrajectoryFormat::kGpx).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(TrajectoryTest, TheExtensionTellsTheFormatUnlessItIsNamed) {
  EXPECT_EQ(*TrajectoryFormatOf("a.GeoJSON", ""), TrajectoryFormat::kGeoJson);
  EXPECT_EQ(*TrajectoryFormatOf("a.json", ""), TrajectoryFormat::kGeoJson);
  EXPECT_EQ(*TrajectoryFormatOf("a.txt", "tum"), TrajectoryFormat::kTum);
  EXPECT_THAT(TrajectoryFormatOf("a.txt", "").status().message(), HasSubstr("a.txt"));
  EXPECT_THAT(TrajectoryFormatOf("a.tum", "xyz").status().message(), HasSubstr("'xyz'"));
}

TEST(TrajectoryTest, ErrorsNameTheLine) {
  const auto error = [](const char* text, TrajectoryFormat format) {
    return std::string(ParseTrajectory(text, format, "file").status().message());
  };
  EXPECT_THAT(error("1.5 0 0 0 0 0 0 1\n1.6 0 0\n", TrajectoryFormat::kTum),
              HasSubstr("file: line 2: has 3 values"));
  EXPECT_THAT(error("1.5 0 0 0 0 0 0 2\n", TrajectoryFormat::kTum), HasSubstr("norm is 2"));
  EXPECT_THAT(error("x 0 0 0 0 0 0 1\n", TrajectoryFormat::kTum), HasSubstr("stamp is 'x'"));
  EXPECT_THAT(error("1 nan 0 0 0 0 0 1\n", TrajectoryFormat::kTum), HasSubstr("x is 'nan'"));
  EXPECT_THAT(error("stamp_ns,x\n", TrajectoryFormat::kCsv), HasSubstr("no column y"));
  EXPECT_THAT(error("stamp_ns,x,y,z,qx,qy,qz,qw,state\n1,0,0,0,0,0,0,1\n", TrajectoryFormat::kCsv),
              HasSubstr("line 2"));
  EXPECT_THAT(error("", TrajectoryFormat::kTum), HasSubstr("no pose"));
}

TEST(TrajectoryTest, StampsOfTumAreReadHoweverTheyAreWritten) {
  const auto stamp_of = [](const std::string& text) -> std::int64_t {
    const auto read = ParseTrajectory(text + " 0 0 0 0 0 0 1\n", TrajectoryFormat::kTum, "file");
    return read.ok() ? read->poses[0].stamp.time_since_epoch().count() : -1;
  };
  EXPECT_EQ(stamp_of("1.100000000000000000e+01"), 11'000'000'000) << "as NumPy writes it";
  EXPECT_EQ(stamp_of("1.5E-01"), 150'000'000);
  EXPECT_EQ(stamp_of("2e3"), 2'000'000'000'000);
  EXPECT_EQ(stamp_of("1714557600.000000001999"), 1'714'557'600'000'000'001);
  EXPECT_EQ(stamp_of("7"), 7'000'000'000);
  EXPECT_EQ(stamp_of("7."), 7'000'000'000);
  EXPECT_EQ(stamp_of(".5"), 500'000'000);
  for (const char* text : {"1.5x", "1.123456789x", "1.5e", "1.2.3", "-0.5", "-1", "1.-5", ".",
                           "nan", "inf", "1e10", "99999999999999999999"}) {
    EXPECT_EQ(stamp_of(text), -1) << text;
  }
}

TEST(TrajectoryTest, AnswersThatAreNoPosesAreLeftOut) {
  const auto read = ParseTrajectory(
      "stamp_ns,radar,state,x,y,z,qx,qy,qz,qw\n1,r,INITIALIZING,0,0,0,0,0,0,1\n"
      "2,r,TRACKING,5,0,0,0,0,0,1\n",
      TrajectoryFormat::kCsv, "answers.csv");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->poses.size(), 1U);
  EXPECT_EQ(read->poses[0].T_map_vehicle.translation_m.x(), 5.0);
}

TEST(TrajectoryTest, ErrorsAreAgainstTheReferenceBetweenItsPoses) {
  Trajectory trajectory = Two();
  const Pose3 half_way{{1.0 / 3.0 + 0.5, 2.2, 0.1}, trajectory.poses[0].T_map_vehicle.rotation};
  trajectory.poses = {{trajectory.poses[0].stamp + std::chrono::milliseconds(500), half_way},
                      {trajectory.poses[1].stamp + std::chrono::seconds(1), half_way}};
  const auto pairs = PairByStamp(trajectory, Two(), std::chrono::seconds(2));
  ASSERT_EQ(pairs.size(), 1U) << "one is after the reference's end";
  EXPECT_NEAR(OffsetOf(pairs[0]).position_m, 0.2, 1e-6);
  EXPECT_NEAR(OffsetOf(pairs[0]).heading_deg, 0.0, 1e-9);
  EXPECT_THAT(PairByStamp(trajectory, Two(), std::chrono::milliseconds(900)), ::testing::IsEmpty())
      << "in a gap of the reference nothing is compared";
}

/// A way of 200 m that bends, and the same way as a trajectory that is `T_truth_map` off.
std::vector<TrajectoryPair> Bend(const Pose2& T_truth_map) {
  std::vector<TrajectoryPair> pairs;
  Pose2 truth;
  for (int i = 0; i < 200; ++i) {
    pairs.push_back({Embed(T_truth_map.Inverse() * truth), Embed(truth)});
    truth = truth * Pose2{{1.0, 0.0}, 0.005};
  }
  return pairs;
}

TEST(TrajectoryTest, AlignmentTakesWhatIsTheFramesAndLeavesWhatIsTheTrajectorys) {
  const Pose2 T_truth_map{{30.0, -4.0}, 0.4};
  std::vector<TrajectoryPair> pairs = Bend(T_truth_map);
  EXPECT_GT(ErrorOf(pairs, {}).rmse_m, 20.0);
  const Pose2 found = AlignTrajectory(pairs);
  EXPECT_NEAR(found.yaw_rad, 0.4, 1e-9);
  const TrajectoryError aligned = ErrorOf(pairs, found);
  EXPECT_NEAR(aligned.rmse_m, 0.0, 1e-9);
  EXPECT_NEAR(aligned.rmse_deg, 0.0, 1e-6);
  pairs[100].T_map_vehicle.translation_m.z() += 2.0;
  EXPECT_NEAR(ErrorOf(pairs, AlignTrajectory(pairs)).max_m, 2.0, 1e-9) << "heights count";
}

TEST(TrajectoryTest, DriftIsTheShareOfTheWayThatIsLost) {
  std::vector<TrajectoryPair> pairs = Bend({});
  EXPECT_NEAR(DriftOver(pairs, 50.0).translation_percent, 0.0, 1e-9);
  for (TrajectoryPair& pair : pairs) pair.T_map_vehicle.translation_m *= 1.02;
  const TrajectoryDrift drift = DriftOver(pairs, 50.0);
  EXPECT_NEAR(drift.translation_percent, 2.0, 0.1);
  EXPECT_GE(drift.segment_count, 149U);
}

}  // namespace
}  // namespace dcloc
