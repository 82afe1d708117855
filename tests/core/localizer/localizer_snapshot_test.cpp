#include "core/localizer/localizer_snapshot.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

constexpr std::size_t kTaken = 60;  // the scan after which the snapshot is taken
constexpr std::size_t kGone = 75;   // the first scan that the earlier localizer does not see

class LocalizerSnapshotTest : public OnARoad {
 protected:
  /// Of a vehicle that tracks, after `kTaken` scans.
  static LocalizerSnapshot Taken() {
    Localizer localizer = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01));
    for (std::size_t i = 0; i < kTaken; ++i) EXPECT_TRUE(localizer.Localize(drive_[i].scan).ok());
    std::optional<LocalizerSnapshot> snapshot = localizer.Snapshot();
    EXPECT_TRUE(snapshot.has_value());
    return snapshot.value_or(LocalizerSnapshot{});
  }

  static Localizer Fresh() { return MakeLocalizer(map_, FrontRadar(), std::nullopt); }

  static std::vector<TrueAnswer> DriveOn(Localizer& localizer) {
    std::vector<TrueAnswer> answers;
    for (std::size_t i = kTaken; i < drive_.size(); ++i) {
      const auto answer = localizer.Localize(drive_[i].scan);
      EXPECT_TRUE(answer.ok()) << answer.status();
      if (answer.ok()) answers.push_back({*answer, drive_[i].T_map_vehicle});
    }
    return answers;
  }
};

/// Squared Mahalanobis distance in the plane.
double SquaredDistance(const Localization& from, const Pose3& to, const Matrix6d& covariance) {
  const Vector6d error = Log(from.T_map_vehicle.Inverse() * to);
  const Eigen::Vector3d planar(error(0), error(1), error(5));
  return planar.dot(FlattenCovariance(covariance).inverse() * planar);
}

TEST_F(LocalizerSnapshotTest, AnotherLocalizerTracksOnAfterASecondOfScans) {
  Localizer localizer = Fresh();
  ASSERT_TRUE(localizer.Restore(Taken()).ok());
  const std::vector<TrueAnswer> answers = DriveOn(localizer);
  for (std::size_t i = kGone - kTaken; i < answers.size(); ++i) {
    EXPECT_TRUE(answers[i].tracking()) << "scan " << i << " after the snapshot";
    EXPECT_LT(answers[i].position_error_m(), 0.4);
  }
}

TEST_F(LocalizerSnapshotTest, ItGoesOnWhereTheEarlierOneWouldHave) {
  Localizer earlier = MakeLocalizer(map_, FrontRadar(), PriorAt(Start(), 0.2, 0.01));
  const std::vector<TrueAnswer> uninterrupted = LocalizeDrive(std::move(earlier), drive_);
  Localizer later = Fresh();
  ASSERT_TRUE(later.Restore(Taken()).ok());
  const std::vector<TrueAnswer> answers = DriveOn(later);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const Localization& answer = answers[i].localization;
    const Localization& other = uninterrupted[kTaken + i].localization;
    EXPECT_LT(SquaredDistance(answer, other.T_map_vehicle, answer.covariance + other.covariance),
              9.0)
        << "scan " << i << " after the snapshot";
  }
}

TEST_F(LocalizerSnapshotTest, BeforeRegistrationsConfirmItTheHoldExpires) {
  Localizer localizer = Fresh();
  LocalizerSnapshot snapshot = Taken();
  ASSERT_TRUE(localizer.Restore(snapshot).ok());
  Scan scan{.stamp = snapshot.stamp + std::chrono::milliseconds(900),
            .radar_id = "front",
            .ego_velocity = snapshot.velocity};
  const auto answer = localizer.Localize(scan);
  ASSERT_TRUE(answer.ok());
  EXPECT_NE(answer->state, LocalizationState::kTracking);
}

TEST_F(LocalizerSnapshotTest, CountsResetsOn) {
  LocalizerSnapshot snapshot = Taken();
  snapshot.resets.count = 4;
  Localizer localizer = Fresh();
  ASSERT_TRUE(localizer.Restore(snapshot).ok());
  EXPECT_EQ(DriveOn(localizer).back().localization.resets.count, 4);
}

TEST_F(LocalizerSnapshotTest, TakenTwiceInARowItIsTheSame) {
  LocalizerSnapshot snapshot = Taken();
  snapshot.contradiction_m = 0.5;
  Localizer localizer = Fresh();
  ASSERT_TRUE(localizer.Restore(snapshot).ok());
  // Nothing was localized in between: all that was taken over is handed on.
  const std::optional<LocalizerSnapshot> again = localizer.Snapshot();
  ASSERT_TRUE(again);
  EXPECT_EQ(again->stamp, snapshot.stamp);
  EXPECT_TRUE(again->pose.T_map_vehicle.translation_m.isApprox(
      snapshot.pose.T_map_vehicle.translation_m, 1e-9));
  EXPECT_EQ(again->tracking.mode, snapshot.tracking.mode);
  EXPECT_EQ(again->tracking.last_accepted, snapshot.tracking.last_accepted);
  EXPECT_EQ(again->noise.translation.odometry_ratio, snapshot.noise.translation.odometry_ratio);
  EXPECT_EQ(again->noise.rotation.far.error, snapshot.noise.rotation.far.error);
  EXPECT_EQ(again->registration_count, snapshot.registration_count);
  EXPECT_EQ(again->mean_nis, snapshot.mean_nis);
  EXPECT_EQ(again->contradiction_m, snapshot.contradiction_m);
}

TEST_F(LocalizerSnapshotTest, ThereIsNoneOfAVehicleThatWasNeverTracked) {
  Localizer localizer = Fresh();
  EXPECT_FALSE(localizer.Snapshot());
  ASSERT_TRUE(localizer.Localize(drive_[0].scan).ok());
  EXPECT_FALSE(localizer.Snapshot());
}

struct SnapshotFault {
  const char* field;
  std::function<void(LocalizerSnapshot&)> make;
};

TEST_F(LocalizerSnapshotTest, WhatIsOutOfBoundsIsRefusedAndChangesNothing) {
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  using S = LocalizerSnapshot;
  const SnapshotFault kFaults[] = {
      {"stamp", [](S& s) { s.stamp = Stamp(std::chrono::nanoseconds(-1)); }},
      {"stamp", [](S& s) { s.stamp = Stamp::max(); }},
      {"last_accepted", [](S& s) { s.tracking.last_accepted = s.stamp + Stamp::duration(1); }},
      {"observability_changed",
       [](S& s) { s.tracking.observability_changed = s.stamp + Stamp::duration(1); }},
      {"mode", [](S& s) { s.tracking.mode = TrackingMode::kSearching; }},
      {"mode", [](S& s) { s.tracking.mode = static_cast<TrackingMode>(99); }},
      {"confirmation_requires",
       [](S& s) { s.tracking.confirmation_requires = static_cast<ConfirmationRequirement>(9); }},
      {"usual_interval_s", [](S& s) { s.tracking.usual_interval_s = kNoNumber; }},
      {"T_map_vehicle", [](S& s) { s.pose.T_map_vehicle.translation_m.x() = kNoNumber; }},
      {"covariance", [](S& s) { s.pose.covariance(0, 0) = -1.0; }},
      {"velocity", [](S& s) { s.velocity.covariance.reset(); }},
      {"linear", [](S& s) { s.velocity.linear_mps.x() = 1e9; }},
      {"wheel_scale",
       [](S& s) {
         s.known.wheel_scale = {9.0, 1.0};
       }},
      {"noise.rotation.far.count", [](S& s) { s.noise.rotation.far.count = kNoNumber; }},
      {"noise.translation.odometry_ratio", [](S& s) { s.noise.translation.odometry_ratio = -1; }},
      {"resets.count", [](S& s) { s.resets.count = -1; }},
      {"resets.T_before_after",
       [](S& s) { s.resets.T_before_after.translation_m.y() = kNoNumber; }},
      {"squared_innovation", [](S& s) { s.mean_nis = kNoNumber; }},
      {"contradiction_m", [](S& s) { s.contradiction_m = -1.0; }},
      {"registration_count", [](S& s) { s.registration_count = -1; }},
      {"clocks_ahead", [](S& s) { s.clocks_ahead = {std::chrono::nanoseconds::max()}; }},
      {"clocks_ahead", [](S& s) { s.clocks_ahead.resize(3); }},
  };
  const LocalizerSnapshot valid = Taken();
  for (const SnapshotFault& fault : kFaults) {
    LocalizerSnapshot snapshot = valid;
    fault.make(snapshot);
    Localizer localizer = Fresh();
    const absl::Status status = localizer.Restore(snapshot);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find(fault.field), absl::string_view::npos) << status;
    EXPECT_FALSE(localizer.has_pose()) << fault.field;
  }
}

// What is valid may be as wrong as it likes.
TEST_F(LocalizerSnapshotTest, NothingValidBreaksIt) {
  using S = LocalizerSnapshot;
  const std::function<void(S&)> kWrongs[] = {
      [](S& s) {
        s.pose.T_map_vehicle.translation_m = {1e9, -1e9, 1e9};
      },
      [](S& s) { s.pose.covariance = Matrix6d::Zero(); },
      [](S& s) { s.pose.covariance = 1e15 * Matrix6d::Identity(); },
      [](S& s) {
        s.velocity.linear_mps = {-150.0, 0.0, 0.0};
      },
      [](S& s) { s.velocity.covariance = Matrix6d::Zero(); },
      [](S& s) { s.noise = {}; },
      [](S& s) {
        s.noise.translation.near = {-1e12, 1e12, 1e12, 1e12, 1e12, 1e12};
        s.noise.translation.far = {1e12, 0.0, 1e12, 1e12, 0.0, 1e12};
      },
      [](S& s) { s.noise.rotation.registration_ratio = 1e6; },
      [](S& s) { s.mean_nis = 1e6; },
      [](S& s) { s.contradiction_m = 1e6; },
      [](S& s) { s.registration_count = 1'000'000'000; },
      [](S& s) { s.tracking.usual_interval_s = 1e3; },
      [](S& s) { s.clocks_ahead = {std::chrono::hours(24 * 300)}; },
      [](S& s) { s.stamp += std::chrono::hours(24 * 300); },
      [](S& s) {
        s.tracking.last_accepted = s.tracking.observability_changed = {};
        s.stamp = {};
      },
  };
  const LocalizerSnapshot valid = Taken();
  for (const auto& make_wrong : kWrongs) {
    LocalizerSnapshot snapshot = valid;
    make_wrong(snapshot);
    Localizer localizer = Fresh();
    ASSERT_TRUE(localizer.Restore(snapshot).ok());
    for (std::size_t i = kTaken; i < drive_.size(); ++i) {
      const auto answer = localizer.Localize(drive_[i].scan);
      if (!answer.ok()) continue;  // a stamp from before the snapshot
      EXPECT_TRUE(answer->T_map_vehicle.translation_m.allFinite());
      EXPECT_TRUE(IsCovariance(answer->covariance));
    }
  }
}

}  // namespace
}  // namespace dcloc
