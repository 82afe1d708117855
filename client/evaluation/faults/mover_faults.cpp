#include "client/evaluation/faults/mover_faults.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::faults {
namespace {

using MoverRandom = std::mt19937_64;

constexpr double kLasts_s = 10.0;
constexpr double kTruckHalfWidth_m = 1.25;
constexpr double kTruckDepth_m = 12.0;
constexpr double kNearestTruck_m = 6.0;
constexpr double kLane_m = 3.5;
constexpr double kConvoyBehind_m = 20.0, kConvoyAhead_m = 40.0;
constexpr int kMaxDraws = 20;

double DrawEvenly(MoverRandom& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Puts targets of moving vehicles into one scan.
class MoverPainter {
 public:
  /// `v_mover_mps` is the vehicles' velocity relative to ours, along our axis.
  MoverPainter(const RadarModel& radar, double v_mover_mps, Scan& scan)
      : radar_(radar), scan_(scan), ego_(scan.ego_velocity.value_or(EgoVelocity{})) {
    v_mover_vehicle_ = {ego_.linear_mps.x() + v_mover_mps, 0.0, 0.0};
    if (scan.size() > 0) {
      const auto [low, high] = std::ranges::minmax(scan.azimuth_rad);
      low_rad_ = static_cast<double>(low);
      high_rad_ = static_cast<double>(high);
    }
  }

  /// Makes the target of `row` one at `p_vehicle`; false where the radar does not look there.
  bool Paint(std::size_t row, const Eigen::Vector2d& p_vehicle) {
    const Pose3 T_radar_vehicle = radar_.T_vehicle_radar.Inverse();
    const double height_m = radar_.T_vehicle_radar.translation_m.z();
    const Eigen::Vector3d p_radar =
        T_radar_vehicle * Eigen::Vector3d(p_vehicle.x(), p_vehicle.y(), height_m);
    const double azimuth_rad = std::atan2(p_radar.y(), p_radar.x());
    if (azimuth_rad < low_rad_ || azimuth_rad > high_rad_) return false;
    const Eigen::Vector3d v_radar_vehicle =
        ego_.linear_mps + ego_.angular_radps.cross(radar_.T_vehicle_radar.translation_m);
    const Eigen::Vector3d v_relative =
        T_radar_vehicle.rotation * (v_mover_vehicle_ - v_radar_vehicle);
    const double range_rate_mps = p_radar.normalized().dot(v_relative);
    const double range_m = p_radar.norm() + radar_.beta_s * range_rate_mps;
    scan_.azimuth_rad[row] = static_cast<float>(azimuth_rad);
    scan_.range_m[row] = static_cast<float>(std::max(0.2, range_m));
    scan_.range_rate_mps[row] = static_cast<float>(range_rate_mps);
    if (!scan_.elevation_rad.empty()) scan_.elevation_rad[row] = 0.0F;
    return true;
  }

  /// The same at the first of some places that `draw` gives which the radar sees.
  template <typename Draw>
  void PaintDrawn(std::size_t row, const Draw& draw) {
    for (int i = 0; i < kMaxDraws; ++i) {
      if (Paint(row, draw())) return;
    }
  }

 private:
  const RadarModel& radar_;
  Scan& scan_;
  EgoVelocity ego_;
  Eigen::Vector3d v_mover_vehicle_;
  double low_rad_ = 0.0, high_rad_ = 0.0;
};

bool LooksAhead(const RadarModel& radar) {
  return std::abs(Yaw(radar.T_vehicle_radar.rotation)) < std::numbers::pi / 3.0;
}

template <typename Draw>
void PaintShare(const RadarModel& radar, double v_mover_mps, MoverRandom& random, const Draw& draw,
                Scan& scan) {
  MoverPainter painter(radar, v_mover_mps, scan);
  std::bernoulli_distribution takes(kMoverShare);
  for (std::size_t row = 0; row < scan.size(); ++row) {
    if (takes(random)) painter.PaintDrawn(row, draw);
  }
}

Fault MakeMoverFault(const std::string& id, std::string label, Fault::Apply apply) {
  return {.id = absl::StrCat("movers-", id),
          .family = "movers",
          .label = std::move(label),
          .duration_s = kLasts_s,
          .apply = std::move(apply)};
}

Fault TruckFault(const std::string& id, std::string label, double gap_m, double relative_mps) {
  return MakeMoverFault(id, std::move(label),
                        [=](Stream& stream, const Window& window, std::uint64_t seed) {
                          PutTruckAhead(stream, window, gap_m, relative_mps, seed);
                        });
}

}  // namespace

void PutTruckAhead(Stream& stream, const Window& window, double gap_m, double relative_mps,
                   std::uint64_t seed) {
  MoverRandom random(seed);
  for (StreamScan& entry : stream.scans) {
    const RadarModel& radar = *stream.rig.Find(entry.scan.radar_id);
    if (!window.Contains(entry.measured) || !LooksAhead(radar)) continue;
    const double t_s = std::chrono::duration<double>(entry.measured - window.begin).count();
    const double back_m = std::max(kNearestTruck_m, gap_m + relative_mps * t_s);
    PaintShare(
        radar, relative_mps, random,
        [&] {
          return Eigen::Vector2d(back_m + DrawEvenly(random, 0.0, kTruckDepth_m),
                                 DrawEvenly(random, -kTruckHalfWidth_m, kTruckHalfWidth_m));
        },
        entry.scan);
  }
}

void PutConvoyBeside(Stream& stream, const Window& window, std::uint64_t seed) {
  MoverRandom random(seed);
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured)) continue;
    PaintShare(
        *stream.rig.Find(entry.scan.radar_id), 0.0, random,
        [&] {
          const double side = std::bernoulli_distribution()(random) ? 1.0 : -1.0;
          return Eigen::Vector2d(DrawEvenly(random, -kConvoyBehind_m, kConvoyAhead_m),
                                 side * kLane_m + DrawEvenly(random, -1.0, 1.0));
        },
        entry.scan);
  }
}

std::vector<Fault> MoverFaults() {
  return {TruckFault("truck-along", "truck ahead, as fast as we are, for 10 s", 10.0, 0.0),
          TruckFault("truck-slower", "truck ahead, 3 m/s slower, for 10 s", 40.0, -3.0),
          TruckFault("truck-faster", "truck ahead, 3 m/s faster, for 10 s", 10.0, 3.0),
          MakeMoverFault("convoy", "convoy on both sides for 10 s",
                         [](Stream& stream, const Window& window, std::uint64_t seed) {
                           PutConvoyBeside(stream, window, seed);
                         })};
}

}  // namespace dcloc::faults
