#include "client/datasets/check/range_rate_check.h"

#include <array>
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

  void Add(const Scan& scan) {
    const Eigen::Vector3d velocity = RadarVelocity(*scan.ego_velocity, T_vehicle_radar_);
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

bool Tells(const Scan& scan) {
  return scan.ego_velocity && scan.ego_velocity->linear_mps.norm() > kMinSpeed_mps;
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
  for (const DriveScan& entry : drive.scans) {
    if (entry.scan.radar_id != radar.id || !Tells(entry.scan)) continue;
    for (Tally& tally : tallies) tally.Add(entry.scan);
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
      return "positive for what comes nearer: set range_rate_is_towards";
    case RangeRateMeaning::kCompensated:
      return "over ground, the vehicle's motion is taken out: set range_rate_is_compensated";
    case RangeRateMeaning::kAwayMirrored:
      return "right, but azimuths are clockwise: set azimuth_is_clockwise";
    case RangeRateMeaning::kTowardsMirrored:
      return "positive for what comes nearer, and azimuths are clockwise: set "
             "range_rate_is_towards and azimuth_is_clockwise";
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
