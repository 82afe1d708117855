#include "client/evaluation/robustness/sites.h"

#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/evaluation/paper/recorded_cases.h"
#include "client/simulation/option_names.h"
#include "client/simulation/simulation.h"

namespace dcloc::robustness {
namespace {

constexpr std::uint64_t kWorldsPerSeed = 1000;  // no world is another seed's

/// A live drive through a world.
struct Pass {
  double speed_kmh;
  bool stops;
};

// When the live drive is between the walls of its world's tunnel.
std::vector<Episode> TunnelEpisodes(const simulation::World& world, const Drive& live) {
  if (!world.tunnel) return {};
  const simulation::PathPoint entry = world.route.At(world.tunnel->begin_m);
  const Pose2 T_tunnel_map = Pose2{entry.position_m, entry.heading_rad}.Inverse();
  const double length_m = world.tunnel->end_m - world.tunnel->begin_m;
  std::vector<Episode> episodes;
  for (const auto& [scan, T_map_vehicle] : live.scans) {
    const Eigen::Vector2d p = T_tunnel_map * Eigen::Vector2d(T_map_vehicle.translation_m.head<2>());
    const bool inside =
        p.x() >= 0.0 && p.x() <= length_m && std::abs(p.y()) <= world.tunnel->half_width_m;
    if (!inside) continue;
    if (episodes.empty()) episodes.push_back({scan.stamp, scan.stamp});
    episodes.back().end = scan.stamp;
  }
  return episodes;
}

absl::StatusOr<Course> Simulate(const SimulationOptions& options, const Pass& pass,
                                const std::string& name) {
  const simulation::World world = MakeWorld(options);
  auto map = SimulatePassWithTruth(world, options,
                                   {.name = "map", .mean_speed_mps = options.map_speed_mps});
  if (!map.ok()) return map.status();
  SimulationOptions live_options = options;
  live_options.stops = pass.stops;
  auto live = SimulatePassWithTruth(
      world, live_options,
      {.name = name, .index = 1, .mean_speed_mps = pass.speed_kmh * kMpsPerKmh});
  if (!live.ok()) return live.status();
  std::vector<Episode> episodes = TunnelEpisodes(world, live->drive);
  return Course{std::move(map->drive), std::move(live->drive), std::move(episodes)};
}

Site MakeSite(const SimulationOptions& options, const Pass& pass) {
  Site site;
  site.name = absl::StrCat(NameOf(options.radar), "-", NameOf(options.world), "-",
                           options.tunnel_m > 0.0 ? "tunnel-" : "", options.seed, "-",
                           pass.speed_kmh, "kmh", pass.stops ? "-stops" : "");
  site.load = [options, pass, name = site.name] { return Simulate(options, pass, name); };
  return site;
}

TrackTrial Disturbed(DisturbanceKind kind, std::uint64_t seed) {
  return {.prior = {.seed = seed}, .plan = DisturbancePlan{.kinds = {kind}, .seed = seed}};
}

void AddTrackTrials(Site& site, std::uint64_t seed) {
  site.trials.emplace_back("undisturbed", TrackTrial{.prior = {.seed = seed}});
  site.trials.emplace_back("outliers", Disturbed(DisturbanceKind::kOutliers, seed));
  site.trials.emplace_back("displaced", Disturbed(DisturbanceKind::kDisplacedCopy, seed));
  site.trials.emplace_back("empty", Disturbed(DisturbanceKind::kEmptyScans, seed));
  site.trials.emplace_back("gap", Disturbed(DisturbanceKind::kGap, seed));
}

void AddTunnelTrial(Site& site, std::uint64_t seed) {
  site.trials.emplace_back("tunnel", TrackTrial{.prior = {.seed = seed}});
}

void AddStartTrials(Site& site, std::uint64_t seed, double spacing_m) {
  const auto start = [&](Prior prior, double translation_m, double rotation_deg) {
    return StartTrial{.prior = prior,
                      .perturbation = {translation_m, rotation_deg, seed},
                      .spacing_m = spacing_m};
  };
  site.trials.emplace_back("start-3m", start(Prior::kPose, 3.0, 5.0));
  site.trials.emplace_back("start-5m", start(Prior::kPose, 5.0, 10.0));
  site.trials.emplace_back("start-gnss", start(Prior::kGnss, 3.0, 0.0));
  site.trials.emplace_back("start-none", start(Prior::kNone, 0.0, 0.0));
}

void AddRecordedTrials(Site& site, std::uint64_t seed) {
  struct First {
    const char* row;
    double translation_m, rotation_deg;
  };
  for (const First& first :
       {First{"recorded-1m", 1.0, 2.0}, {"recorded-3m", 3.0, 5.0}, {"recorded-5m", 5.0, 10.0}}) {
    site.trials.emplace_back(
        first.row, TrackTrial{.prior = {first.translation_m, first.rotation_deg, seed},
                              .plan = DisturbancePlan{.kinds = {DisturbanceKind::kOutliers,
                                                                DisturbanceKind::kGap,
                                                                DisturbanceKind::kDisplacedCopy,
                                                                DisturbanceKind::kEmptyScans},
                                                      .interval_s = 6.0,
                                                      .seed = seed},
                              .session_s = 20.0});
  }
  // Slow vehicles need longer to come over ground that tells places apart.
  const StartTrial start{.prior = Prior::kGnss,
                         .perturbation = {.translation_m = 3.0, .rotation_deg = 0.0, .seed = seed},
                         .spacing_m = 5.0,
                         .limit_s = 10.0};
  site.trials.emplace_back("recorded-start-gnss", start);
  StartTrial from_nothing = start;
  from_nothing.prior = Prior::kNone;
  site.trials.emplace_back("recorded-start-none", from_nothing);
}

/// Sites one after the other, each in a world of its own, whose seed all else at it follows from.
class SimulatedSiteList {
 public:
  explicit SimulatedSiteList(std::uint64_t seed) : last_seed_(kWorldsPerSeed * (seed + 1)) {}

  void AddDrive(SimulationOptions options, const Pass& pass) {
    options.seed = ++last_seed_;
    AddTrackTrials(Add(options, pass), options.seed);
  }
  void AddTunnel(SimulationOptions options, const Pass& pass) {
    options.seed = ++last_seed_;
    AddTunnelTrial(Add(options, pass), options.seed);
  }
  void AddStarts(SimulationOptions options, const Pass& pass, double spacing_m) {
    options.seed = ++last_seed_;
    AddStartTrials(Add(options, pass), options.seed, spacing_m);
  }

  std::vector<Site> Take() { return std::move(sites_); }

 private:
  Site& Add(const SimulationOptions& options, const Pass& pass) {
    return sites_.emplace_back(MakeSite(options, pass));
  }

  std::uint64_t last_seed_;
  std::vector<Site> sites_;
};

std::vector<Site> QuickSites(std::uint64_t seed) {
  SimulatedSiteList sites(seed);
  sites.AddDrive({.length_m = 250.0}, {40.0, false});
  sites.AddTunnel({.length_m = 260.0, .tunnel_m = 100.0}, {60.0, false});
  sites.AddStarts({.length_m = 250.0}, {50.0, false}, 40.0);
  return sites.Take();
}

}  // namespace

std::vector<Site> SimulatedSites(std::uint64_t seed, bool quick) {
  if (quick) return QuickSites(seed);
  constexpr double kLength_m = 2000.0;
  constexpr double kSpacing_m = 6.0;  // three hundred starts in two kilometres, and some
  constexpr Pass kSlow{40.0, false}, kFast{100.0, false}, kWithStops{60.0, true};
  SimulatedSiteList sites(seed);
  for (const auto& [radar_name, radar] : kRadarNames) {
    for (const auto& [world_name, world] : kWorldNames) {
      const bool is_town = world == WorldKind::kTown;
      const SimulationOptions options{.world = world, .radar = radar, .length_m = kLength_m};
      sites.AddDrive(options, kSlow);
      sites.AddDrive(options, is_town ? kWithStops : kFast);
      sites.AddTunnel({.world = world, .radar = radar, .length_m = 900.0, .tunnel_m = 300.0},
                      is_town ? kSlow : kFast);
    }
  }
  sites.AddStarts({.length_m = kLength_m}, {50.0, false}, kSpacing_m);
  sites.AddStarts({.radar = RadarKind::kCarla, .length_m = kLength_m}, {50.0, false}, kSpacing_m);
  sites.AddStarts({.world = WorldKind::kHighway, .length_m = kLength_m}, kFast, 2.0 * kSpacing_m);
  return sites.Take();
}

absl::StatusOr<std::vector<Site>> RecordedSites(const std::filesystem::path& folder,
                                                std::uint64_t seed) {
  const auto cases = paper::RecordedCases(folder);
  if (!cases.ok()) return cases.status();
  std::vector<Site> sites;
  for (const paper::Case& item : *cases) {
    Site& site = sites.emplace_back();
    site.name = item.name;
    site.load = [load = item.load]() -> absl::StatusOr<Course> {
      auto drives = load();
      if (!drives.ok()) return drives.status();
      return Course{std::move(drives->map), std::move(drives->live), {}};
    };
    AddRecordedTrials(site, seed);
  }
  return sites;
}

}  // namespace dcloc::robustness
