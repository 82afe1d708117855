#include "client/evaluation/disturbance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include <cmath>
#include <map>

#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

using ::testing::HasSubstr;

constexpr int kTargets = 40;
constexpr double kSpeed_mps = 10.0;

// A minute straight ahead with two radars, fifty milliseconds between one and the other.
Drive MakeDrive() {
  Drive drive{.name = "straight"};
  drive.rig.radars = {{.id = "front"}, {.id = "left"}};
  drive.rig.radars[0].T_vehicle_radar.translation_m.x() = 3.0;
  drive.rig.radars[1].T_vehicle_radar.rotation =
      Eigen::AngleAxisd(90.0 * kRadPerDeg, Eigen::Vector3d::UnitZ());
  for (int i = 0; i < 1200; ++i) {
    DriveScan& entry = drive.scans.emplace_back();
    entry.scan.stamp = Stamp(std::chrono::milliseconds(50 * i));
    entry.scan.radar_id = i % 2 == 0 ? "front" : "left";
    entry.scan.ego_velocity.emplace();
    entry.scan.ego_velocity->linear_mps.x() = kSpeed_mps;
    entry.T_map_vehicle.translation_m.x() = 0.05 * kSpeed_mps * i;
    for (int k = 0; k < kTargets; ++k) {
      entry.scan.range_m.push_back(5.0F + static_cast<float>(k));
      entry.scan.azimuth_rad.push_back(-0.8F + 0.04F * static_cast<float>(k));
      entry.scan.range_rate_mps.push_back(-3.0F);
      entry.scan.rcs_dbsm.push_back(1.0F);
    }
  }
  return drive;
}

DisturbedDrive DisturbedBy(DisturbanceKind kind, std::uint64_t seed = 1) {
  auto disturbed = Disturb(MakeDrive(), {.kinds = {kind}, .seed = seed});
  EXPECT_TRUE(disturbed.ok()) << disturbed.status();
  return *std::move(disturbed);
}

// The scan of the drive as it was.
const DriveScan& Original(const Drive& drive, const DriveScan& disturbed) {
  const auto index = disturbed.scan.stamp.time_since_epoch() / std::chrono::milliseconds(50);
  return drive.scans.at(static_cast<std::size_t>(index));
}

TEST(DisturbanceTest, TouchesTenScansOfEachRadarAboutEveryTenSecondsAndNothingElse) {
  const Drive drive = MakeDrive();
  const DisturbedDrive disturbed = DisturbedBy(DisturbanceKind::kOutliers);
  EXPECT_EQ(disturbed.drive.scans.size(), drive.scans.size());
  ASSERT_EQ(disturbed.touched.size(), disturbed.drive.scans.size());
  EXPECT_EQ(disturbed.episodes.size(), 6U);
  std::map<std::string, int> touched;
  for (std::size_t i = 0; i < disturbed.touched.size(); ++i) {
    const DriveScan& entry = disturbed.drive.scans[i];
    const bool in_episode = std::ranges::any_of(disturbed.episodes, [&](const Episode& episode) {
      return entry.scan.stamp >= episode.begin && entry.scan.stamp <= episode.end;
    });
    EXPECT_EQ(disturbed.touched[i], in_episode);
    EXPECT_EQ(entry.T_map_vehicle.translation_m, drive.scans[i].T_map_vehicle.translation_m);
    if (disturbed.touched[i]) {
      ++touched[entry.scan.radar_id];
      EXPECT_NE(entry.scan.range_m, drive.scans[i].scan.range_m);
    } else {
      EXPECT_EQ(entry.scan.range_m, drive.scans[i].scan.range_m);
    }
  }
  EXPECT_EQ(touched["front"], 60);
  EXPECT_EQ(touched["left"], 60);
}

TEST(DisturbanceTest, OutliersReplaceTheirShareAndHalfOfThemStandStill) {
  const Drive drive = MakeDrive();
  const DisturbedDrive disturbed = DisturbedBy(DisturbanceKind::kOutliers);
  double replaced = 0.0, standing = 0.0, all = 0.0;
  for (std::size_t i = 0; i < disturbed.touched.size(); ++i) {
    if (!disturbed.touched[i]) continue;
    const Scan& scan = disturbed.drive.scans[i].scan;
    ASSERT_TRUE(Validate(scan).ok()) << Validate(scan);
    ASSERT_EQ(scan.size(), static_cast<std::size_t>(kTargets));
    const double mount_rad = scan.radar_id == "left" ? 90.0 * kRadPerDeg : 0.0;
    for (std::size_t row = 0; row < scan.size(); ++row) {
      ++all;
      if (scan.range_m[row] == drive.scans[i].scan.range_m[row]) continue;
      ++replaced;
      const double still_mps =
          -kSpeed_mps * std::cos(static_cast<double>(scan.azimuth_rad[row]) + mount_rad);
      if (std::abs(static_cast<double>(scan.range_rate_mps[row]) - still_mps) < 1e-4) ++standing;
    }
  }
  EXPECT_NEAR(replaced / all, 0.6, 0.03);
  EXPECT_NEAR(standing / replaced, 0.5, 0.04);
}

TEST(DisturbanceTest, ADisplacedCopyIsTheSameSceneryFromOnePlaceAside) {
  const Drive drive = MakeDrive();
  const DisturbedDrive disturbed = DisturbedBy(DisturbanceKind::kDisplacedCopy);
  const auto points = [&](const Scan& scan) {
    const Pose3& T_vehicle_radar = drive.rig.Find(scan.radar_id)->T_vehicle_radar;
    Eigen::Matrix3Xd p(3, kTargets);
    for (int k = 0; k < kTargets; ++k) {
      const auto row = static_cast<std::size_t>(k);
      const auto range = static_cast<double>(scan.range_m[row]);
      const auto azimuth = static_cast<double>(scan.azimuth_rad[row]);
      p.col(k) = T_vehicle_radar *
                 Eigen::Vector3d(range * std::cos(azimuth), range * std::sin(azimuth), 0.0);
    }
    return p;
  };
  for (const Episode& episode : disturbed.episodes) {
    std::optional<Eigen::Matrix4d> first;
    for (const DriveScan& entry : disturbed.drive.scans) {
      if (entry.scan.stamp < episode.begin || entry.scan.stamp > episode.end) continue;
      const Scan& truth = Original(drive, entry).scan;
      EXPECT_EQ(entry.scan.range_rate_mps, truth.range_rate_mps);
      const Eigen::Matrix4d T_seen_true =
          Eigen::umeyama(points(truth), points(entry.scan), /*with_scaling=*/false);
      if (!first) first = T_seen_true;
      EXPECT_LT((T_seen_true - *first).norm(), 1e-4);  // one place for both radars and all scans
      const Eigen::Vector3d aside =
          -T_seen_true.topLeftCorner<3, 3>().transpose() * T_seen_true.topRightCorner<3, 1>();
      EXPECT_GT(aside.norm(), 2.0 - 1e-4);
      EXPECT_LT(aside.norm(), 5.0 + 1e-4);
      const double turn_deg =
          std::abs(std::atan2(T_seen_true(1, 0), T_seen_true(0, 0))) * kDegPerRad;
      EXPECT_GT(turn_deg, 2.0 - 1e-3);
      EXPECT_LT(turn_deg, 6.0 + 1e-3);
    }
    EXPECT_TRUE(first.has_value());
  }
}

TEST(DisturbanceTest, EmptyScansKeepTheirStampsAndTheVehiclesVelocity) {
  const DisturbedDrive disturbed = DisturbedBy(DisturbanceKind::kEmptyScans);
  for (std::size_t i = 0; i < disturbed.touched.size(); ++i) {
    const Scan& scan = disturbed.drive.scans[i].scan;
    EXPECT_EQ(scan.size(), disturbed.touched[i] ? 0U : static_cast<std::size_t>(kTargets));
    EXPECT_TRUE(Validate(scan).ok());
    EXPECT_TRUE(scan.ego_velocity.has_value());
  }
}

TEST(DisturbanceTest, AGapTakesScansAway) {
  const Drive drive = MakeDrive();
  const DisturbedDrive disturbed = DisturbedBy(DisturbanceKind::kGap);
  EXPECT_NEAR(static_cast<double>(drive.scans.size() - disturbed.drive.scans.size()), 6 * 40, 6);
  for (const Episode& episode : disturbed.episodes) {
    EXPECT_NEAR(std::chrono::duration<double>(episode.end - episode.begin).count(), 2.0, 0.06);
    for (const DriveScan& entry : disturbed.drive.scans) {
      EXPECT_FALSE(entry.scan.stamp >= episode.begin && entry.scan.stamp <= episode.end);
    }
  }
}

TEST(DisturbanceTest, TakesItsKindsInTurnAndLeavesRoomAtTheEnd) {
  const auto disturbed =
      Disturb(MakeDrive(), {.kinds = {DisturbanceKind::kEmptyScans, DisturbanceKind::kGap}});
  ASSERT_TRUE(disturbed.ok());
  ASSERT_EQ(disturbed->episodes.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto within = std::ranges::count_if(disturbed->drive.scans, [&](const DriveScan& entry) {
      return entry.scan.stamp >= disturbed->episodes[i].begin &&
             entry.scan.stamp <= disturbed->episodes[i].end;
    });
    EXPECT_EQ(within, i % 2 == 0 ? 20 : 0);
  }
  EXPECT_LE(disturbed->episodes.back().end + std::chrono::seconds(4),
            disturbed->drive.scans.back().scan.stamp);
}

TEST(DisturbanceTest, FollowsFromItsSeed) {
  const auto ranges = [](const DisturbedDrive& disturbed) {
    std::vector<std::vector<float>> all;
    for (const DriveScan& entry : disturbed.drive.scans) all.push_back(entry.scan.range_m);
    return all;
  };
  const auto first = ranges(DisturbedBy(DisturbanceKind::kOutliers, 3));
  EXPECT_EQ(first, ranges(DisturbedBy(DisturbanceKind::kOutliers, 3)));
  EXPECT_NE(first, ranges(DisturbedBy(DisturbanceKind::kOutliers, 4)));
}

TEST(DisturbanceTest, LeavesAShortDriveAlone) {
  Drive drive = MakeDrive();
  drive.scans.resize(60);
  const auto disturbed = Disturb(drive, {.kinds = {DisturbanceKind::kGap}});
  ASSERT_TRUE(disturbed.ok());
  EXPECT_TRUE(disturbed->episodes.empty());
  EXPECT_EQ(disturbed->drive.scans.size(), 60U);
  drive.scans.clear();
  EXPECT_TRUE(Disturb(drive, {.kinds = {DisturbanceKind::kGap}})->drive.scans.empty());
}

TEST(DisturbanceTest, NamesWhatIsWrongWithAPlan) {
  const auto message = [](const DisturbancePlan& plan) {
    return std::string(Disturb(MakeDrive(), plan).status().message());
  };
  EXPECT_THAT(message({}), HasSubstr("kinds is empty"));
  EXPECT_THAT(message({.kinds = {DisturbanceKind::kGap}, .interval_s = 1.0}),
              HasSubstr("interval_s is 1; it must lie in [5, 1000]"));
  EXPECT_THAT(message({.kinds = {DisturbanceKind::kGap}, .outlier_share = std::nan("")}),
              HasSubstr("outlier_share is nan"));
}

}  // namespace
}  // namespace dcloc
