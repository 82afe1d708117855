#include "client/simulation/radar/scan_simulator.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "client/simulation/radar/ghosts.h"

namespace dcloc::simulation {
namespace {

constexpr double kMinMeasuredRange = 0.2;  // [m]
constexpr double kSaturationDb = 25.0;     // stronger echoes have no better rank

std::vector<Echo> SortedByStrength(std::vector<Echo> echoes) {
  std::stable_sort(echoes.begin(), echoes.end(),
                   [](const Echo& a, const Echo& b) { return a.snr_db > b.snr_db; });
  return echoes;
}

// Of echoes in one resolution cell, the radar reports the strongest.
std::vector<Echo> Resolve(std::vector<Echo> echoes, const RadarProfile& profile) {
  std::vector<Echo> resolved;
  for (const Echo& echo : SortedByStrength(std::move(echoes))) {
    const Observation& weak = echo.observation;
    const bool is_masked = std::any_of(resolved.begin(), resolved.end(), [&](const Echo& other) {
      const Observation& strong = other.observation;
      return std::abs(weak.range_m - strong.range_m) < profile.range_resolution_m &&
             std::abs(weak.azimuth_rad - strong.azimuth_rad) < profile.azimuth_resolution_rad &&
             std::abs(weak.range_rate_mps - strong.range_rate_mps) <
                 profile.range_rate_resolution_mps;
    });
    if (!is_masked) resolved.push_back(echo);
  }
  return resolved;
}

// At most `count` of them, by strength as blurred by `noise_db`.
std::vector<Echo> Select(const std::vector<Echo>& echoes, std::size_t count, double noise_db,
                         Random& random) {
  std::vector<double> rank(echoes.size());
  std::transform(echoes.begin(), echoes.end(), rank.begin(), [&](const Echo& echo) {
    return std::min(echo.snr_db, kSaturationDb) + Normal(random, 0.0, noise_db);
  });
  std::vector<std::size_t> order(echoes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rank[a] > rank[b]; });
  order.resize(std::min(count, order.size()));
  std::vector<Echo> selected;
  selected.reserve(order.size());
  for (const std::size_t i : order) selected.push_back(echoes[i]);
  return selected;
}

// False alarms: half of them ground clutter that stands still, half of any range rate.
Echo MakeClutter(const RadarView& view, const RadarProfile& profile, Random& random) {
  const double range_m = Uniform(random, 2.0, profile.max_range_m);
  const double azimuth = Uniform(random, -profile.half_field_rad, profile.half_field_rad);
  Echo echo;
  echo.source = EchoSource::kClutter;
  echo.p_map = view.T_map_radar *
               Eigen::Vector3d(range_m * std::cos(azimuth), range_m * std::sin(azimuth), 0.0);
  echo.observation = view.Observe(echo.p_map, Eigen::Vector3d::Zero());
  if (Chance(random, 0.5)) echo.observation.range_rate_mps = Uniform(random, -25.0, 25.0);
  echo.rcs_dbsm = std::max(profile.min_rcs_dbsm, Normal(random, -1.0, 3.0));
  return echo;
}

std::size_t DrawCap(const RadarProfile& profile, Random& random) {
  return static_cast<std::size_t>(
      std::uniform_int_distribution<int>(profile.min_targets, profile.max_targets)(random));
}

std::vector<Echo> DetectEchoes(const Scene& scene, const std::vector<MovingBody>& bodies,
                               const RadarView& view, const ScanSimulatorOptions& options,
                               Random& random) {
  const RadarProfile& profile = options.profile;
  const Occlusion occlusion = CollectOcclusion(scene, bodies, view, profile);
  std::vector<Echo> echoes =
      Resolve(CollectEchoes(scene, bodies, occlusion, view, profile, random), profile);
  std::erase_if(echoes, [&](const Echo&) { return Chance(random, profile.miss_probability); });

  const std::size_t cap = DrawCap(profile, random);
  const double listed = static_cast<double>(std::min(cap, echoes.size()));
  const auto ghost_count = static_cast<std::size_t>(Poisson(random, options.ghost_share * listed));
  const auto clutter_count =
      static_cast<std::size_t>(Poisson(random, options.clutter_share * listed));
  // Ghosts flicker: which of the possible ones show is up to chance.
  const std::vector<Echo> ghosts =
      Select(Resolve(CollectGhosts(echoes, occlusion, view, profile), profile), ghost_count, 100.0,
             random);

  const std::size_t spurious = std::min(cap, ghosts.size() + clutter_count);
  echoes = Select(echoes, cap - spurious, profile.selection_noise_db, random);
  echoes.insert(echoes.end(), ghosts.begin(), ghosts.end());
  for (std::size_t i = 0; i < clutter_count; ++i) {
    echoes.push_back(MakeClutter(view, profile, random));
  }
  if (echoes.size() > cap) echoes.resize(cap);
  return echoes;
}

// What would be measured of the same place on the ground at the radar's own height.
Observation Flattened(Observation observation) {
  const double cos_elevation = std::cos(observation.elevation_rad);
  observation.range_m *= cos_elevation;
  observation.range_rate_mps /= cos_elevation;
  observation.elevation_rad = 0.0;
  return observation;
}

double Fold(double range_rate, double unambiguous) {
  if (unambiguous <= 0.0) return range_rate;
  const double period = 2.0 * unambiguous;
  return range_rate - period * std::floor((range_rate + unambiguous) / period);
}

double Quantise(double value, double step) {
  return step > 0.0 ? step * std::round(value / step) : value;
}

}  // namespace

bool AppendMeasurement(const Echo& echo, const RadarModel& radar,
                       const ScanSimulatorOptions& options, Random& random, Scan& scan) {
  const RadarProfile& profile = options.profile;
  const Observation& truth = echo.observation;
  double spread = 1.0;
  double angle_spread = 1.0;
  if (profile.noise_depends_on_target) {
    spread = std::clamp(1.3 - echo.snr_db / 40.0, 0.7, 1.3);
    angle_spread = spread / std::cos(truth.azimuth_rad);
  }
  const double range =
      truth.range_m + radar.beta_s * truth.range_rate_mps + spread * profile.range_m.Draw(random);
  const double azimuth =
      WrapAngle(truth.azimuth_rad + angle_spread * profile.azimuth_rad.Draw(random));
  const double range_rate = truth.range_rate_mps + spread * profile.range_rate_mps.Draw(random);
  const double elevation = truth.elevation_rad + spread * profile.elevation_rad.Draw(random);
  const double rcs = echo.rcs_dbsm + Normal(random, 0.0, 1.0);
  if (range < kMinMeasuredRange) return false;
  scan.range_m.push_back(static_cast<float>(range));
  scan.azimuth_rad.push_back(static_cast<float>(azimuth));
  scan.range_rate_mps.push_back(static_cast<float>(
      Fold(Quantise(range_rate, options.range_rate_step_mps), radar.unambiguous_range_rate_mps)));
  if (radar.has_elevation) scan.elevation_rad.push_back(static_cast<float>(elevation));
  scan.rcs_dbsm.push_back(static_cast<float>(Quantise(rcs, 0.5)));
  return true;
}

SimulatedScan SimulateScan(const Scene& scene, const std::vector<MovingBody>& bodies,
                           const MotionState& motion, const RadarModel& radar,
                           const ScanSimulatorOptions& options, Random& random) {
  const RadarView view = ViewFrom(motion, radar.T_vehicle_radar);
  std::vector<Echo> echoes = DetectEchoes(scene, bodies, view, options, random);
  if (options.is_flat) {
    for (Echo& echo : echoes) echo.observation = Flattened(echo.observation);
  }
  std::stable_sort(echoes.begin(), echoes.end(), [](const Echo& a, const Echo& b) {
    return a.observation.range_m < b.observation.range_m;
  });
  SimulatedScan simulated;
  for (const Echo& echo : echoes) {
    if (AppendMeasurement(echo, radar, options, random, simulated.scan)) {
      simulated.echoes.push_back(echo);
    }
  }
  return simulated;
}

}  // namespace dcloc::simulation
