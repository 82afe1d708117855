// Bags of ROS 1: what ExportBag writes comes back to the bit, and what is broken is named.
#include "client/datasets/rosbag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "client/datasets/bag_overview.h"
#include "client/datasets/check/range_rate_check.h"
#include "client/datasets/export_bag.h"
#include "client/rosbag/bag_reader.h"
#include "tests/client/datasets/temp_folder.h"
#include "tests/client/datasets/two_radars.h"

namespace dcloc {
namespace {

using rosbag::Compression;
using ::testing::HasSubstr;

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class RosbagTest : public ::testing::Test {
 protected:
  std::filesystem::path Bag() const { return folder_.path() / "drive.bag"; }
  void Export(const Drive& drive, Compression compression = Compression::kLz4) const {
    const absl::Status status = ExportBag(drive, Bag(), compression);
    ASSERT_TRUE(status.ok()) << status;
  }
  absl::StatusOr<Drive> Read(const DriveRequest& request = {.name = "drive"}) const {
    return ReadRosbagDrive(folder_.path(), request);
  }
  void Map(const std::string& json) const { folder_.Write("dcloc_bag.json", json); }

  TempFolder folder_;
};

void ExpectSame(const Drive& a, const Drive& b) {
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    const Scan& x = a.scans[i].scan;
    const Scan& y = b.scans[i].scan;
    EXPECT_EQ(x.stamp, y.stamp);
    EXPECT_EQ(x.radar_id, y.radar_id);
    EXPECT_EQ(x.range_m, y.range_m);
    EXPECT_EQ(x.range_rate_mps, y.range_rate_mps);
    EXPECT_EQ(x.azimuth_rad, y.azimuth_rad);
    EXPECT_EQ(x.elevation_rad, y.elevation_rad);
    EXPECT_EQ(x.rcs_dbsm, y.rcs_dbsm);
    ASSERT_EQ(x.ego_velocity.has_value(), y.ego_velocity.has_value());
    EXPECT_EQ(x.ego_velocity->linear_mps, y.ego_velocity->linear_mps);
    EXPECT_EQ(x.ego_velocity->angular_radps, y.ego_velocity->angular_radps);
    EXPECT_EQ(x.ego_velocity->covariance, y.ego_velocity->covariance);
    EXPECT_EQ(a.scans[i].T_map_vehicle.translation_m, b.scans[i].T_map_vehicle.translation_m);
    EXPECT_EQ(a.scans[i].T_map_vehicle.rotation.coeffs(),
              b.scans[i].T_map_vehicle.rotation.coeffs());
  }
  for (const RadarModel& radar : a.rig.radars) {
    const RadarModel* const other = b.rig.Find(radar.id);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(radar.beta_s, other->beta_s);
    EXPECT_EQ(radar.T_vehicle_radar.rotation.coeffs(), other->T_vehicle_radar.rotation.coeffs());
    EXPECT_EQ(radar.T_vehicle_radar.translation_m, other->T_vehicle_radar.translation_m);
  }
}

TEST_F(RosbagTest, ADriveComesBackToTheBitHoweverItIsPacked) {
  for (const Compression compression : {Compression::kNone, Compression::kBz2, Compression::kLz4}) {
    Export(TwoRadars(), compression);
    const auto drive = Read();
    ASSERT_TRUE(drive.ok()) << drive.status();
    EXPECT_EQ(drive->pose_source, PoseSource::kReference);
    EXPECT_THAT(drive->notes, ::testing::IsEmpty());
    ExpectSame(TwoRadars(), *drive);
  }
}

TEST_F(RosbagTest, OfABagThatIsCutOffTheWholePartIsRead) {
  Export(TwoRadars(), Compression::kNone);
  const std::string bytes = ReadBytes(Bag());
  // Within the only chunk, near its end.
  folder_.Write("drive.bag", bytes.substr(0, bytes.size() - 8000));
  const auto drive = Read();
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_LT(drive->scans.size(), TwoRadars().scans.size());
  EXPECT_GT(drive->scans.size(), 10U);
  ASSERT_EQ(drive->notes.size(), 1U);
  EXPECT_THAT(drive->notes[0], HasSubstr("cut off at byte"));
}

TEST_F(RosbagTest, NoCutAtAllMakesItFallOver) {
  Export(TwoRadars(), Compression::kLz4);
  const std::string bytes = ReadBytes(Bag());
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    folder_.Write("drive.bag", bytes.substr(0, size));
    std::int64_t count = 0;
    const auto summary = rosbag::ReadBag(Bag(), [&](const rosbag::Message&) {
      ++count;
      return absl::OkStatus();
    });
    EXPECT_EQ(summary.ok(), size >= 13) << size;
    if (summary.ok()) {
      EXPECT_EQ(summary->message_count, count);
    }
  }
}

TEST_F(RosbagTest, DamageIsNamed) {
  Export(TwoRadars(), Compression::kLz4);
  std::string bytes = ReadBytes(Bag());
  bytes[4096 + 2000] = static_cast<char>(bytes[4096 + 2000] ^ 0x55);
  folder_.Write("drive.bag", bytes);
  EXPECT_EQ(Read().status().code(), absl::StatusCode::kDataLoss) << Read().status();
  folder_.Write("drive.bag", "#ROSBAG V1.2\n");
  EXPECT_THAT(Read().status().message(), HasSubstr("rosbag fix"));
  folder_.Write("drive.bag", "nonsense");
  EXPECT_THAT(Read().status().message(), HasSubstr("is no bag"));
  EXPECT_THAT(Read({.name = "other"}).status().message(), HasSubstr("the bags are drive"));
}

TEST_F(RosbagTest, AMappingThatDoesNotFitIsNamed) {
  Export(TwoRadars());
  Map(R"({"radars": [{"id": "front", "topic": "/nowhere", "range": "range", "azimuth": "azimuth",
                      "range_rate": "range_rate"}]})");
  EXPECT_THAT(Read().status().message(), HasSubstr("no messages of topic /nowhere"));
  Map(R"({"radars": [{"id": "front", "topic": "/radar/front/points", "range": "range",
                      "azimuth": "azimuth", "range_rate": "doppler"}]})");
  EXPECT_THAT(Read().status().message(), HasSubstr("no field \"doppler\"; its fields are x, y, z"));
  Map(R"({"radars": [{"id": "front", "topic": "/vehicle/velocity", "range": "range",
                      "azimuth": "azimuth", "range_rate": "range_rate"}]})");
  EXPECT_THAT(Read().status().message(), HasSubstr("must be sensor_msgs/PointCloud2"));
  Map(R"({"radars": [], "colour": "red"})");
  EXPECT_THAT(Read().status().message(), HasSubstr("colour"));
}

TEST_F(RosbagTest, WhatCannotBeWrittenLeavesTheOlderBag) {
  Export(TwoRadars());
  const std::string older = ReadBytes(Bag());
  Drive early = TwoRadars();
  early.scans.back().scan.stamp = Stamp(std::chrono::hours(24 * 365 * 150));
  EXPECT_THAT(ExportBag(early, Bag(), Compression::kLz4).message(), HasSubstr("2106"));
  Drive other = TwoRadars();
  other.rig.radars[0].beta_s = 0.05;
  EXPECT_THAT(ExportBag(other, Bag(), Compression::kLz4).message(), HasSubstr("other radars"));
  EXPECT_EQ(ReadBytes(Bag()), older);
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
    count += entry.is_regular_file() ? 1U : 0U;
  }
  EXPECT_EQ(count, 2U) << "the bag and its rig, nothing half-written";
}

TEST_F(RosbagTest, SignsAndMountsAreToldByTheData) {
  Drive drive = TwoRadars();
  const auto meanings = [](const Drive& checked) {
    std::vector<RangeRateMeaning> result;
    for (const RangeRateCheck& check : CheckRangeRates(checked)) result.push_back(check.meaning);
    return result;
  };
  using enum RangeRateMeaning;
  EXPECT_THAT(meanings(drive), ::testing::ElementsAre(kAway, kAway));
  Drive towards = drive;
  for (DriveScan& entry : towards.scans) {
    for (float& rate : entry.scan.range_rate_mps) rate = -rate;
  }
  EXPECT_THAT(meanings(towards), ::testing::ElementsAre(kTowards, kTowards));
  Drive over_ground = drive;
  for (DriveScan& entry : over_ground.scans) {
    for (float& rate : entry.scan.range_rate_mps) rate = 0.0F;
  }
  EXPECT_THAT(meanings(over_ground), ::testing::ElementsAre(kCompensated, kCompensated));
  Drive mirrored = drive;
  for (DriveScan& entry : mirrored.scans) {
    for (float& azimuth : entry.scan.azimuth_rad) azimuth = -azimuth;
  }
  EXPECT_THAT(meanings(mirrored), ::testing::ElementsAre(kAwayMirrored, kAwayMirrored));
  Drive swapped = drive;
  for (DriveScan& entry : swapped.scans) {
    entry.scan.radar_id = entry.scan.radar_id == "front" ? "rear" : "front";
  }
  // With mounts that look the other way, the sign is wrong as well as the mount.
  for (const RangeRateMeaning meaning : meanings(swapped)) EXPECT_NE(meaning, kAway);
}

TEST_F(RosbagTest, PosesTellTheVelocityWhereNothingElseDoes) {
  Drive drive = TwoRadars();
  for (DriveScan& entry : drive.scans) {
    entry.scan.ego_velocity.reset();
    for (float& rate : entry.scan.range_rate_mps) rate = -rate;
  }
  EXPECT_EQ(CheckRangeRates(drive)[0].meaning, RangeRateMeaning::kTowards);
  drive.pose_source = PoseSource::kNone;
  EXPECT_EQ(CheckRangeRates(drive)[0].meaning, RangeRateMeaning::kUnknown);
}

TEST_F(RosbagTest, TheOverviewHasTheStamps) {
  Export(TwoRadars());
  const auto overview = ReadBagOverview(Bag());
  ASSERT_TRUE(overview.ok()) << overview.status();
  const BagTopic* const front = overview->Find("/radar/front/points");
  ASSERT_NE(front, nullptr);
  EXPECT_EQ(front->stamps.count, 20);
  EXPECT_EQ(front->stamps.first, TwoRadars().scans.front().scan.stamp);
  EXPECT_EQ(front->stamps.backward_count, 0);
  EXPECT_NEAR(front->stamps.longest_gap_s, 0.14, 1e-6);
  EXPECT_EQ(front->stamps.greatest_delay_s, 0.0);
  EXPECT_EQ(overview->Find("/tf")->stamps.count, 0);
}

TEST_F(RosbagTest, AMappingTurnsSignsBack) {
  Drive drive = TwoRadars();
  for (DriveScan& entry : drive.scans) {
    for (float& rate : entry.scan.range_rate_mps) rate = -rate;
    for (float& azimuth : entry.scan.azimuth_rad) azimuth = -azimuth;
  }
  Export(drive);
  Map(R"({"motion_topic": "/vehicle/velocity", "radars": [
      {"id": "front", "topic": "/radar/front/points", "range": "range", "azimuth": "azimuth",
       "range_rate": "range_rate", "rcs": "rcs", "azimuth_is_clockwise": true,
       "range_rate_is_towards": true},
      {"id": "rear", "topic": "/radar/rear/points", "range": "range", "azimuth": "azimuth",
       "range_rate": "range_rate", "rcs": "rcs", "azimuth_is_clockwise": true,
       "range_rate_is_towards": true}]})");
  const auto read = Read();
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(TwoRadars(), *read);
}

}  // namespace
}  // namespace dcloc
