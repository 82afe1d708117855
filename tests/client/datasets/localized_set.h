#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "client/datasets/dataset.h"
#include "client/datasets/drive_map.h"
#include "client/datasets/export_bag.h"
#include "client/datasets/rosbag.h"
#include "core/localizer/localizer.h"
#include "core/map/radar_map.h"
#include "tests/client/datasets/temp_folder.h"

namespace dcloc {

/// A drive as a user reads it.
inline Drive ReadDriveOf(const Dataset& dataset, const std::string& name) {
  absl::StatusOr<Drive> drive = ReadDrive(dataset, {.name = name});
  EXPECT_TRUE(drive.ok()) << drive.status();
  return drive.ok() ? *std::move(drive) : Drive();
}

/// The reference poses that were read are those of `written`, whose body sits at `T_vehicle_body`.
inline void ExpectPosesOf(const Drive& read, const Drive& written, const Pose3& T_vehicle_body,
                          double max_m, double max_rad) {
  ASSERT_EQ(read.scans.size(), written.scans.size());
  EXPECT_EQ(read.pose_source, PoseSource::kReference);
  for (std::size_t i = 0; i < read.scans.size(); ++i) {
    const Pose3 expected = written.scans[i].T_map_vehicle * T_vehicle_body;
    const Pose3 error = expected.Inverse() * read.scans[i].T_map_vehicle;
    ASSERT_EQ(read.scans[i].scan.stamp, written.scans[i].scan.stamp);
    ASSERT_EQ(read.scans[i].scan.size(), written.scans[i].scan.size());
    EXPECT_LT(error.translation_m.norm(), max_m) << i;
    EXPECT_LT(RotationAngle(error), max_rad) << i;
  }
}

/// The answers to a drive's scans, from a first pose that is known to half a metre and two degrees.
inline std::vector<Localization> LocalizeIn(const std::shared_ptr<const RadarMap>& map,
                                            const Drive& drive) {
  Vector6d variances;
  variances << 0.25, 0.25, 0.01, 1e-4, 1e-4, 1e-3;
  const InitialPose begin{drive.scans.at(0).T_map_vehicle, variances.asDiagonal()};
  absl::StatusOr<Localizer> localizer = Localizer::Create(map, drive.rig, begin);
  EXPECT_TRUE(localizer.ok()) << localizer.status();
  std::vector<Localization> answers;
  for (const DriveScan& entry : drive.scans) {
    const absl::StatusOr<Localization> answer = localizer->Localize(entry.scan);
    EXPECT_TRUE(answer.ok()) << answer.status();
    if (answer.ok()) answers.push_back(*answer);
  }
  return answers;
}

inline std::shared_ptr<const RadarMap> MapOfDrive(const Drive& drive) {
  const auto bytes = BuildMap(drive, {.name = "map"});
  EXPECT_TRUE(bytes.ok()) << bytes.status();
  return bytes.ok() ? RadarMap::FromBytes(*bytes).value() : nullptr;
}

/// 85 % of the answers and more are TRACKING, those of the first seconds not yet, and the median
/// position error is below `max_median_m`.
inline void ExpectLocalized(const std::vector<Localization>& answers, const Drive& drive,
                            double max_median_m) {
  ASSERT_EQ(answers.size(), drive.scans.size());
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (answers[i].state != LocalizationState::kTracking) continue;
    const Pose3 error = drive.scans[i].T_map_vehicle.Inverse() * answers[i].T_map_vehicle;
    errors_m.push_back(error.translation_m.head<2>().norm());
  }
  ASSERT_GT(errors_m.size(), answers.size() * 85 / 100);
  const auto middle = errors_m.begin() + static_cast<std::ptrdiff_t>(errors_m.size() / 2);
  std::ranges::nth_element(errors_m, middle);
  ::testing::Test::RecordProperty("median_error_mm", static_cast<int>(1000.0 * *middle));
  EXPECT_LT(*middle, max_median_m);
}

/// A bag that is made of the drive is localized alike, to the bit.
inline void ExpectTheSameAsABag(const std::shared_ptr<const RadarMap>& map, const Drive& drive,
                                const std::vector<Localization>& answers) {
  const TempFolder folder;
  const absl::Status written =
      ExportBag(drive, folder.path() / "live.bag", rosbag::Compression::kNone);
  ASSERT_TRUE(written.ok()) << written;
  const absl::StatusOr<Drive> bag = ReadRosbagDrive(folder.path(), {.name = "live"});
  ASSERT_TRUE(bag.ok()) << bag.status();
  const std::vector<Localization> again = LocalizeIn(map, *bag);
  ASSERT_EQ(again.size(), answers.size());
  for (std::size_t i = 0; i < again.size(); ++i) {
    const Localization& a = answers[i];
    const Localization& b = again[i];
    ASSERT_EQ(a.state, b.state) << i;
    ASSERT_EQ(a.T_map_vehicle.translation_m, b.T_map_vehicle.translation_m) << i;
    ASSERT_EQ(a.T_map_vehicle.rotation.coeffs(), b.T_map_vehicle.rotation.coeffs()) << i;
    ASSERT_EQ(a.covariance, b.covariance) << i;
  }
}

}  // namespace dcloc
