#include "client/evaluation/robustness/sites.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/evaluation/paper/recorded_cases.h"
#include "client/evaluation/robustness/course.h"
#include "client/simulation/option_names.h"

namespace dcloc::robustness {
namespace {

constexpr std::uint64_t kWorldsPerSeed = 1000;  // no world is another seed's

Site MakeSite(const SimulationOptions& options, const Pass& pass) {
  Site site;
  site.name = absl::StrCat(NameOf(options.radar), "-", NameOf(options.world), "-",
                           options.tunnel_m > 0.0 ? "tunnel-" : "", options.seed, "-",
                           pass.speed_kmh, "kmh", pass.stops ? "-stops" : "");
  site.load = [options, pass, name = site.name] { return SimulateCourse(options, pass, name); };
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
