#include "client/simulation/radar/echoes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "client/simulation/world/path.h"

namespace dcloc::simulation {
namespace {

constexpr double kNothing = -std::numeric_limits<double>::infinity();
constexpr double kMinRange = 0.8;       // [m]
constexpr double kFluctuationDb = 2.0;  // from scan to scan
constexpr double kDeepestFadeDb = 8.0;  // what fluctuation could still lift over the threshold
constexpr double kOwnSkin = 0.35;       // of the object that a scatterer belongs to [m]
constexpr double kGlintDbsm = 9.0;
constexpr double kReflectionDbsm = 8.0;  // of a smooth wall, seen at a right angle
constexpr double kReflectionSpreadDb = 4.0;
constexpr double kWallThickness = 0.03;  // of a smooth wall's reflections, across it [m]

double Radius(const RadarProfile& profile) {
  return std::max(profile.max_range_m, profile.far_max_range_m);
}

double LobesDb(std::uint32_t id, double aspect_rad) {
  const double phase = static_cast<double>(id % 6283U) * 1e-3;
  return 2.5 * (std::sin(23.0 * aspect_rad + phase) + std::sin(41.0 * aspect_rad + 2.3 * phase));
}

class EchoCollector {
 public:
  EchoCollector(const Occlusion& occlusion, const RadarView& view, const RadarProfile& profile,
                Random& random)
      : occlusion_(occlusion), view_(view), profile_(profile), random_(random) {}

  void Add(const Scatterer& scatterer, const Eigen::Vector3d& velocity_mps, EchoSource source) {
    const Eigen::Vector2d to_radar =
        (view_.T_map_radar.translation_m - scatterer.position_m).head<2>();
    if (to_radar.squaredNorm() > Radius(profile_) * Radius(profile_)) return;
    const double rcs = AspectRcsDbsm(scatterer, std::atan2(to_radar.y(), to_radar.x()));
    if (rcs == kNothing) return;
    AddAt(scatterer.position_m, velocity_mps, rcs, scatterer.extent_m, scatterer.id, source);
  }

  void AddGlint(const Wall& wall) {
    const Eigen::Vector2d side = wall.end_m - wall.begin_m;
    const Eigen::Vector2d to_radar = view_.T_map_radar.translation_m.head<2>() - wall.begin_m;
    const double share = to_radar.dot(side) / side.squaredNorm();
    if (share < 0.0 || share > 1.0) return;
    const double height_m = view_.T_map_radar.translation_m.z();
    if (height_m > wall.height_m) return;
    Eigen::Vector3d foot;
    foot << wall.begin_m + share * side, height_m;
    // A wall is rougher here and smoother there: lobes by place stand for that.
    const double rcs = kGlintDbsm + LobesDb(1, share * side.norm() / 10.0);
    AddAt(foot, Eigen::Vector3d::Zero(), rcs, 0.03, 0, EchoSource::kGlint);
  }

  void AddReflections(const Wall& wall) {
    const Eigen::Vector2d side = wall.end_m - wall.begin_m;
    const Eigen::Vector2d across = LeftOf(std::atan2(side.y(), side.x()));
    const int count = Poisson(random_, wall.reflections_per_m * side.norm());
    for (int i = 0; i < count; ++i) {
      Eigen::Vector3d position;
      position << wall.begin_m + Uniform(random_, 0.0, 1.0) * side, Uniform(random_, 0.3, 3.0);
      const Eigen::Vector3d sight = position - view_.T_map_radar.translation_m;
      const double grazing = std::abs(across.dot(sight.head<2>().normalized()));
      const double rcs = Normal(random_, kReflectionDbsm, kReflectionSpreadDb) +
                         10.0 * std::log10(std::max(grazing, 1e-3));
      AddAt(position, Eigen::Vector3d::Zero(), rcs, kWallThickness, 0, EchoSource::kReflection);
    }
  }

  std::vector<Echo> Take() { return std::move(echoes_); }

 private:
  void AddAt(const Eigen::Vector3d& p_map, const Eigen::Vector3d& velocity_mps, double rcs_dbsm,
             double extent_m, std::uint32_t id, EchoSource source) {
    Echo echo{source, p_map, velocity_mps, view_.Observe(p_map, velocity_mps), rcs_dbsm, 0.0, id};
    if (echo.observation.range_m < kMinRange || Snr(echo) < -kDeepestFadeDb) return;
    const double loss_db = occlusion_.LossDb(p_map, kOwnSkin);
    if (loss_db >= kOpaqueDb) return;
    echo.rcs_dbsm += Normal(random_, 0.0, kFluctuationDb) - 2.0 * loss_db;
    echo.p_map.x() += Normal(random_, 0.0, extent_m);
    echo.p_map.y() += Normal(random_, 0.0, extent_m);
    echo.observation = view_.Observe(echo.p_map, velocity_mps);
    echo.snr_db = Snr(echo);
    if (echo.snr_db > 0.0 && echo.rcs_dbsm > profile_.min_rcs_dbsm) echoes_.push_back(echo);
  }

  double Snr(const Echo& echo) const {
    return echo.rcs_dbsm + BeamGainDb(profile_, echo.observation);
  }

  const Occlusion& occlusion_;
  const RadarView& view_;
  const RadarProfile& profile_;
  Random& random_;
  std::vector<Echo> echoes_;
};

void AddBody(const MovingBody& body, EchoCollector& collector) {
  for (Scatterer scatterer : body.vehicle->scatterers) {
    scatterer.position_m = Embed(body.T_map_body) * scatterer.position_m;
    scatterer.facing_rad += body.T_map_body.yaw_rad;
    const Eigen::Vector2d lever = scatterer.position_m.head<2>() - body.T_map_body.translation_m;
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
    velocity.head<2>() =
        body.velocity_mps + body.yaw_rate_radps * Eigen::Vector2d(-lever.y(), lever.x());
    collector.Add(scatterer, velocity, EchoSource::kMoving);
  }
}

}  // namespace

double BeamGainDb(const RadarProfile& profile, const Observation& observation) {
  const double side = std::abs(observation.azimuth_rad);
  const double near_share = side / profile.half_field_rad;
  double gain_db = kNothing;
  if (near_share <= 1.0 && observation.range_m <= profile.max_range_m) {
    gain_db = -profile.edge_loss_db * near_share * near_share;
  }
  if (side <= profile.far_half_field_rad && observation.range_m <= profile.far_max_range_m) {
    const double far_share = side / profile.far_half_field_rad;
    gain_db = std::max(gain_db, profile.far_gain_db * (1.0 - far_share * far_share));
  }
  const double tilt = observation.elevation_rad / profile.elevation_half_power_rad;
  return gain_db - 3.0 * tilt * tilt +
         40.0 * std::log10(profile.reference_range_m / observation.range_m);
}

double AspectRcsDbsm(const Scatterer& scatterer, double aspect_rad) {
  double rcs_dbsm = scatterer.rcs_dbsm + LobesDb(scatterer.id, aspect_rad);
  if (scatterer.half_sector_rad < std::numbers::pi) {
    const double off = std::abs(WrapAngle(aspect_rad - scatterer.facing_rad));
    if (off >= scatterer.half_sector_rad) return kNothing;
    rcs_dbsm +=
        10.0 * std::log10(std::cos(0.5 * std::numbers::pi * off / scatterer.half_sector_rad));
  }
  return rcs_dbsm;
}

Occlusion CollectOcclusion(const Scene& scene, const std::vector<MovingBody>& bodies,
                           const RadarView& view, const RadarProfile& profile) {
  Occlusion occlusion(view.T_map_radar.translation_m);
  scene.VisitWalls(view.T_map_radar.translation_m.head<2>(), Radius(profile),
                   [&](const Wall& wall) { occlusion.Add(wall); });
  for (const MovingBody& body : bodies) {
    for (const Wall& side : Outline(*body.vehicle, body.T_map_body)) occlusion.Add(side);
  }
  return occlusion;
}

std::vector<Echo> CollectEchoes(const Scene& scene, const std::vector<MovingBody>& bodies,
                                const Occlusion& occlusion, const RadarView& view,
                                const RadarProfile& profile, Random& random) {
  EchoCollector collector(occlusion, view, profile, random);
  scene.VisitScatterers(view.T_map_radar.translation_m.head<2>(), Radius(profile),
                        [&](const Scatterer& scatterer) {
                          collector.Add(scatterer, Eigen::Vector3d::Zero(), EchoSource::kStatic);
                        });
  for (const Wall& wall : occlusion.walls()) {
    if (wall.is_mirror) collector.AddGlint(wall);
    if (wall.reflections_per_m > 0.0) collector.AddReflections(wall);
  }
  for (const MovingBody& body : bodies) AddBody(body, collector);
  return collector.Take();
}

}  // namespace dcloc::simulation
