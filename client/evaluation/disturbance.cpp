#include "client/evaluation/disturbance.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "client/datasets/files/check_range.h"
#include "core/geometry/degrees.h"

namespace dcloc {
namespace {

constexpr double kMinRange_m = 0.2;
constexpr double kOutlierReach_m = 80.0;
constexpr double kOutlierSpeed_mps = 25.0;
constexpr double kMinAside_m = 2.0;
constexpr double kMaxAside_m = 5.0;
constexpr double kMinTurn_deg = 2.0;
constexpr double kMaxTurn_deg = 6.0;
constexpr double kJitter = 0.2;       // of the interval, to either side
constexpr double kRoomAfter_s = 4.0;  // of drive after an episode

using EpisodeRandom = std::mt19937_64;

double DrawBetween(EpisodeRandom& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

EpisodeRandom RandomForEpisode(std::uint64_t seed, std::uint64_t episode) {
  std::seed_seq seeds{seed & 0xffffffffU, seed >> 32U, episode};
  return EpisodeRandom(seeds);
}

std::chrono::nanoseconds ToNanoseconds(double seconds) {
  return std::chrono::round<std::chrono::nanoseconds>(std::chrono::duration<double>(seconds));
}

double Elevation(const Scan& scan, std::size_t row) {
  return scan.elevation_rad.empty() ? 0.0 : static_cast<double>(scan.elevation_rad[row]);
}

Eigen::Vector3d Direction(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad),
          std::cos(elevation_rad) * std::sin(azimuth_rad), std::sin(elevation_rad)};
}

Eigen::Vector3d VelocityOfRadar(const EgoVelocity& ego, const RadarModel& radar) {
  return radar.T_vehicle_radar.rotation.conjugate() *
         (ego.linear_mps + ego.angular_radps.cross(radar.T_vehicle_radar.translation_m));
}

/// What happens to the scans of one episode.
class Disturber {
 public:
  Disturber(const DisturbancePlan& plan, DisturbanceKind kind, std::uint64_t episode)
      : plan_(plan), kind_(kind), random_(RandomForEpisode(plan.seed, episode)) {
    const double direction_rad = DrawBetween(random_, -std::numbers::pi, std::numbers::pi);
    const double aside_m = DrawBetween(random_, kMinAside_m, kMaxAside_m);
    const double turn_deg = DrawBetween(random_, kMinTurn_deg, kMaxTurn_deg);
    const double side = std::bernoulli_distribution()(random_) ? 1.0 : -1.0;
    T_vehicle_aside_.translation_m =
        aside_m * Eigen::Vector3d(std::cos(direction_rad), std::sin(direction_rad), 0.0);
    T_vehicle_aside_.rotation =
        Eigen::AngleAxisd(side * turn_deg * kRadPerDeg, Eigen::Vector3d::UnitZ());
  }

  void Apply(const RadarModel& radar, Scan& scan) {
    switch (kind_) {
      case DisturbanceKind::kOutliers:
        return ReplaceTargets(radar, scan);
      case DisturbanceKind::kDisplacedCopy:
        return Displace(radar, scan);
      case DisturbanceKind::kEmptyScans:
        return Empty(scan);
      case DisturbanceKind::kGap:
        return;
    }
  }

 private:
  void ReplaceTargets(const RadarModel& radar, Scan& scan) {
    if (scan.size() == 0) return;
    const auto [low, high] = std::ranges::minmax(scan.azimuth_rad);
    for (std::size_t row = 0; row < scan.size(); ++row) {
      if (!std::bernoulli_distribution(plan_.outlier_share)(random_)) continue;
      const double azimuth_rad = DrawBetween(random_, low, high);
      scan.azimuth_rad[row] = static_cast<float>(azimuth_rad);
      scan.range_m[row] = static_cast<float>(DrawBetween(random_, kMinAside_m, kOutlierReach_m));
      double range_rate_mps = DrawBetween(random_, -kOutlierSpeed_mps, kOutlierSpeed_mps);
      if (scan.ego_velocity && std::bernoulli_distribution()(random_)) {
        range_rate_mps = -Direction(azimuth_rad, Elevation(scan, row))
                              .dot(VelocityOfRadar(*scan.ego_velocity, radar));
      }
      scan.range_rate_mps[row] = static_cast<float>(range_rate_mps);
    }
  }

  void Displace(const RadarModel& radar, Scan& scan) const {
    const Pose3 T_aside_radar =
        radar.T_vehicle_radar.Inverse() * T_vehicle_aside_.Inverse() * radar.T_vehicle_radar;
    for (std::size_t row = 0; row < scan.size(); ++row) {
      const Eigen::Vector3d p =
          T_aside_radar * Eigen::Vector3d(static_cast<double>(scan.range_m[row]) *
                                          Direction(static_cast<double>(scan.azimuth_rad[row]),
                                                    Elevation(scan, row)));
      scan.range_m[row] = static_cast<float>(std::max(kMinRange_m, p.norm()));
      scan.azimuth_rad[row] = static_cast<float>(std::atan2(p.y(), p.x()));
      if (!scan.elevation_rad.empty()) {
        scan.elevation_rad[row] = static_cast<float>(std::atan2(p.z(), p.head<2>().norm()));
      }
    }
  }

  static void Empty(Scan& scan) {
    Scan empty{.stamp = scan.stamp, .radar_id = scan.radar_id, .ego_velocity = scan.ego_velocity};
    scan = std::move(empty);
  }

  const DisturbancePlan& plan_;
  DisturbanceKind kind_;
  EpisodeRandom random_;
  Pose3 T_vehicle_aside_;
};

/// Goes through a drive from one episode to the next.
class Disturbing {
 public:
  Disturbing(const Drive& drive, const DisturbancePlan& plan) : drive_(drive), plan_(plan) {
    result_.drive.name = drive.name;
    result_.drive.place = drive.place;
    result_.drive.rig = drive.rig;
  }

  DisturbedDrive Run() {
    std::size_t next = 0;
    for (std::uint64_t episode = 0;; ++episode) {
      const std::size_t begin = std::max(next, BeginOf(episode));
      const DisturbanceKind kind = plan_.kinds[episode % plan_.kinds.size()];
      const std::size_t end = EndOf(begin, kind);
      if (!HasRoomAfter(end)) break;
      for (; next < begin; ++next) Keep(next, false);
      AddEpisode(begin, end, kind, episode);
      next = end;
    }
    for (; next < drive_.scans.size(); ++next) Keep(next, false);
    return std::move(result_);
  }

 private:
  Stamp StampOf(std::size_t index) const { return drive_.scans[index].scan.stamp; }

  // Of an episode, the index of its first scan.
  std::size_t BeginOf(std::uint64_t episode) const {
    EpisodeRandom random = RandomForEpisode(plan_.seed, ~episode);
    const double at_s = plan_.interval_s * (static_cast<double>(episode) + 0.5 +
                                            DrawBetween(random, -kJitter, kJitter));
    return FirstAfter(StampOf(0) + ToNanoseconds(at_s));
  }

  // The index after its last scan.
  std::size_t EndOf(std::size_t begin, DisturbanceKind kind) const {
    if (begin == drive_.scans.size()) return begin;
    if (kind == DisturbanceKind::kGap)
      return FirstAfter(StampOf(begin) + ToNanoseconds(plan_.gap_s));
    const std::size_t count =
        static_cast<std::size_t>(plan_.burst_scans) * drive_.rig.radars.size();
    return std::min(begin + count, drive_.scans.size());
  }

  std::size_t FirstAfter(Stamp stamp) const {
    const auto after = std::ranges::upper_bound(
        drive_.scans, stamp, {}, [](const DriveScan& entry) { return entry.scan.stamp; });
    return static_cast<std::size_t>(after - drive_.scans.begin());
  }

  bool HasRoomAfter(std::size_t end) const {
    return end < drive_.scans.size() &&
           StampOf(end) + ToNanoseconds(kRoomAfter_s) <= drive_.scans.back().scan.stamp;
  }

  void AddEpisode(std::size_t begin, std::size_t end, DisturbanceKind kind, std::uint64_t episode) {
    result_.episodes.push_back({StampOf(begin), StampOf(end - 1)});
    if (kind == DisturbanceKind::kGap) return;
    Disturber disturber(plan_, kind, episode);
    for (std::size_t i = begin; i < end; ++i) {
      Keep(i, true);
      Scan& scan = result_.drive.scans.back().scan;
      disturber.Apply(*drive_.rig.Find(scan.radar_id), scan);
    }
  }

  void Keep(std::size_t index, bool touched) {
    result_.drive.scans.push_back(drive_.scans[index]);
    result_.touched.push_back(touched);
  }

  const Drive& drive_;
  const DisturbancePlan& plan_;
  DisturbedDrive result_;
};

}  // namespace

absl::Status Validate(const DisturbancePlan& plan) {
  if (plan.kinds.empty()) return absl::InvalidArgumentError("kinds is empty; it must name one");
  absl::Status status = CheckRange("interval_s", plan.interval_s, 5.0, 1000.0);
  status.Update(CheckRange("burst_scans", plan.burst_scans, 1, 1000));
  status.Update(CheckRange("outlier_share", plan.outlier_share, 0.0, 1.0));
  status.Update(CheckRange("gap_s", plan.gap_s, 0.1, 100.0));
  return status;
}

absl::StatusOr<DisturbedDrive> Disturb(const Drive& drive, const DisturbancePlan& plan) {
  if (absl::Status status = Validate(plan); !status.ok()) return status;
  if (absl::Status status = CheckRadarsOfScans(drive); !status.ok()) return status;
  if (drive.scans.empty()) return DisturbedDrive{.drive = drive};
  return Disturbing(drive, plan).Run();
}

}  // namespace dcloc
