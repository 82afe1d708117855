#include "client/datasets/check/range_rate_check.h"

#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "absl/strings/str_cat.h"
#include "core/geometry/pose.h"

namespace dcloc {
namespace {

constexpr double kMinSpeed_mps = 2.0;
constexpr double kMinPredicted_mps = 1.5;
constexpr double kGate_mps = 0.5;
constexpr double kGateOfSpeed = 0.04;  ///< velocities and directions are known to some percent
constexpr std::size_t kMinTargets = 200;
constexpr double kMinShare = 0.3;  ///< less stand still nowhere but in a jam
constexpr double kClearlyBetter = 1.3;
constexpr std::chrono::nanoseconds kPoseStep = std::chrono::milliseconds(100);
constexpr std::chrono::nanoseconds kMaxPoseSpan = std::chrono::seconds(1);

/// An explanation of the range rates.
struct Hypothesis {
  RangeRateMeaning meaning;
  double sign;  ///< of range rates; 0: over ground
  double azimuth_sign;
};

constexpr std::array kHypotheses = {
    Hypothesis{RangeRateMeaning::kAway, 1.0, 1.0},
    Hypothesis{RangeRateMeaning::kTowards, -1.0, 1.0},
    Hypothesis{RangeRateMeaning::kCompensated, 0.0, 1.0},
    Hypothesis{RangeRateMeaning::kAwayMirrored, 1.0, -1.0},
    Hypothesis{RangeRateMeaning::kTowardsMirrored, -1.0, -1.0},
};

/// The radar's velocity in its own frame.
Eigen::Vector3d RadarVelocity(const EgoVelocity& ego, const Pose3& T_vehicle_radar) {
  const Eigen::Vector3d v_vehicle =
      ego.linear_mps + ego.angular_radps.cross(T_vehicle_radar.translation_m);
  return T_vehicle_radar.rotation.conjugate() * v_vehicle;
}

/// How many targets an explanation fits, of those that a thing standing there would show moving.
class Tally {
 public:
  Tally(const Pose3& T_vehicle_radar, Hypothesis hypothesis)
      : T_vehicle_radar_(T_vehicle_radar), hypothesis_(hypothesis) {}

  void Add(const Scan& scan, const EgoVelocity& ego) {
    const Eigen::Vector3d velocity = RadarVelocity(ego, T_vehicle_radar_);
    const double gate = kGate_mps + kGateOfSpeed * velocity.norm();
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const double azimuth = hypothesis_.azimuth_sign * scan.azimuth_rad[i];
      const double elevation = scan.elevation_rad.empty() ? 0.0F : scan.elevation_rad[i];
      const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                      std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double standing = -velocity.dot(direction);
      if (std::abs(standing) < kMinPredicted_mps + gate) continue;
      ++count_;
      const double expected = hypothesis_.sign * standing;
      if (std::abs(scan.range_rate_mps[i] - expected) < gate) ++fitting_count_;
    }
  }

  std::size_t count() const { return count_; }
  double share() const {
    return count_ < kMinTargets ? 0.0
                                : static_cast<double>(fitting_count_) / static_cast<double>(count_);
  }

 private:
  const Pose3& T_vehicle_radar_;
  Hypothesis hypothesis_;
  std::size_t count_ = 0;
  std::size_t fitting_count_ = 0;
};

/// The vehicle's velocity at scan `index` by the poses of the scans around it; nothing where they
/// are too far.
std::optional<EgoVelocity> VelocityByPoses(const Drive& drive, std::size_t index) {
  if (drive.pose_source == PoseSource::kNone) return std::nullopt;
  const Stamp stamp = drive.scans[index].scan.stamp;
  std::size_t before = index;
  std::size_t after = index;
  while (before > 0 && stamp - drive.scans[before].scan.stamp < kPoseStep) --before;
  while (after + 1 < drive.scans.size() && drive.scans[after].scan.stamp - stamp < kPoseStep) {
    ++after;
  }
  const auto duration = drive.scans[after].scan.stamp - drive.scans[before].scan.stamp;
  if (duration < kPoseStep || duration > kMaxPoseSpan) return std::nullopt;
  const Vector6d twist =
      Log(drive.scans[before].T_map_vehicle.Inverse() * drive.scans[after].T_map_vehicle) /
      std::chrono::duration<double>(duration).count();
  return EgoVelocity{twist.head<3>(), twist.tail<3>(), std::nullopt};
}

/// The velocity by which the targets of a scan tell something.
std::optional<EgoVelocity> TellingVelocity(const Drive& drive, std::size_t index) {
  const Scan& scan = drive.scans[index].scan;
  const bool tells = scan.ego_velocity && drive.velocity_source == VelocitySource::kVehicle;
  const std::optional<EgoVelocity> velocity =
      tells ? scan.ego_velocity : VelocityByPoses(drive, index);
  if (!velocity || velocity->linear_mps.norm() <= kMinSpeed_mps) return std::nullopt;
  return velocity;
}

/// A candidate's tally is the best one where it is clearly better than all before it.
void Consider(const Tally& tally, RangeRateMeaning meaning, const std::string& mount,
              RangeRateCheck& check) {
  if (tally.share() < kMinShare || tally.share() < kClearlyBetter * check.best_share) return;
  check.meaning = meaning;
  check.better_mount = mount;
  check.best_share = tally.share();
}

RangeRateCheck CheckRangeRatesOf(const Drive& drive, const RadarModel& radar) {
  std::vector<Tally> tallies;
  for (const Hypothesis& hypothesis : kHypotheses) {
    tallies.emplace_back(radar.T_vehicle_radar, hypothesis);
  }
  std::vector<const RadarModel*> others;
  for (const RadarModel& other : drive.rig.radars) {
    if (&other == &radar) continue;
    others.push_back(&other);
    tallies.emplace_back(other.T_vehicle_radar, kHypotheses.front());
  }
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    const Scan& scan = drive.scans[i].scan;
    if (scan.radar_id != radar.id) continue;
    const std::optional<EgoVelocity> velocity = TellingVelocity(drive, i);
    if (!velocity) continue;
    for (Tally& tally : tallies) tally.Add(scan, *velocity);
  }
  RangeRateCheck check{.radar_id = radar.id,
                       .target_count = tallies.front().count(),
                       .fitting_share = tallies.front().share()};
  if (check.target_count < kMinTargets) return check;
  check.meaning = RangeRateMeaning::kNothingFits;
  for (std::size_t i = 0; i < kHypotheses.size(); ++i) {
    Consider(tallies[i], kHypotheses[i].meaning, "", check);
  }
  for (std::size_t i = 0; i < others.size(); ++i) {
    Consider(tallies[kHypotheses.size() + i], RangeRateMeaning::kOfAnotherMount, others[i]->id,
             check);
  }
  return check;
}

}  // namespace

std::vector<RangeRateCheck> CheckRangeRates(const Drive& drive) {
  std::vector<RangeRateCheck> checks;
  checks.reserve(drive.rig.radars.size());
  for (const RadarModel& radar : drive.rig.radars)
    checks.push_back(CheckRangeRatesOf(drive, radar));
  return checks;
}

std::string MeaningText(const RangeRateCheck& check) {
  switch (check.meaning) {
    case RangeRateMeaning::kUnknown:
      return "unknown: too few targets while the vehicle moves at a known velocity";
    case RangeRateMeaning::kAway:
      return "positive for what recedes, relative to the moving radar, as they must be";
    case RangeRateMeaning::kTowards:
      return "positive for what comes nearer: the other sign is needed";
    case RangeRateMeaning::kCompensated:
      return "over ground: the vehicle's own motion is taken out";
    case RangeRateMeaning::kAwayMirrored:
      return "right, but azimuths are clockwise: the other sign is needed";
    case RangeRateMeaning::kTowardsMirrored:
      return "positive for what comes nearer, and azimuths are clockwise: the other sign is needed "
             "of both";
    case RangeRateMeaning::kOfAnotherMount:
      return absl::StrCat("right as if the radar sat where ", check.better_mount,
                          " does: are their mounts or names swapped?");
    case RangeRateMeaning::kNothingFits:
      return "fit neither sign, nor any mount of the rig: check the mount's yaw, the units and the "
             "clocks";
  }
  return "unknown";
}

}  // namespace dcloc
