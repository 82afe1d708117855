#include "client/cli/simulate/simulate_command.h"

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/anchor_option.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/progress.h"
#include "client/simulation/fix_simulator.h"
#include "client/simulation/nuscenes_writer.h"
#include "client/simulation/option_names.h"
#include "client/simulation/simulation.h"

namespace dcloc::cli {
namespace {

struct SimulateArguments {
  SimulationOptions options;
  FixOptions fixes;
  std::optional<GeodeticAnchor> anchor;  ///< of fixes on the Earth
  double map_speed_kmh = 72.0;
  std::vector<double> live_speeds_kmh = {40.0};
  std::string out;
  bool force = false;
};

void PrintPass(const SimulatedPass& pass, double length_m) {
  const std::vector<DriveScan>& scans = pass.drive.scans;
  std::size_t target_count = 0;
  for (const DriveScan& entry : scans) target_count += entry.scan.size();
  const double duration_s =
      std::chrono::duration<double>(scans.back().scan.stamp - scans.front().scan.stamp).count();
  absl::PrintF("%-8s %5d scans, %5.1f targets each, %6.1f s, mean speed %.1f km/h\n",
               pass.drive.name, scans.size(),
               static_cast<double>(target_count) / static_cast<double>(scans.size()), duration_s,
               length_m / duration_s / kMpsPerKmh);
}

absl::Status Simulate(SimulateArguments arguments) {
  SimulationOptions& options = arguments.options;
  options.map_speed_mps = arguments.map_speed_kmh * kMpsPerKmh;
  options.live_speeds_mps.clear();
  for (const double kmh : arguments.live_speeds_kmh) {
    options.live_speeds_mps.push_back(kmh * kMpsPerKmh);
  }
  absl::Status valid = Validate(options);
  valid.Update(Validate(arguments.fixes));
  if (!valid.ok()) return valid;

  auto writer = NuScenesWriter::Create(arguments.out, arguments.force);
  if (!writer.ok()) return writer.status();
  const simulation::World world = MakeWorld(options);
  const simulation::AgedWorld aged = AgeWorld(world, options);
  for (const PassOptions& pass : Passes(options)) {
    absl::StatusOr<SimulatedPass> simulated;
    {
      Progress progress("simulating " + pass.name);
      simulated = SimulatePassWithTruth(pass.index > 0 ? aged.world : world, options, pass,
                                        [&](double share) { progress.UpdateShare(share); });
    }
    if (!simulated.ok()) return simulated.status();
    if (absl::Status status = writer->AddPass(*simulated); !status.ok()) return status;
    if (arguments.fixes.rate_hz > 0.0) {
      const auto fixes = SimulateFixes(*simulated, DrawOf(options.day, pass.index), arguments.fixes,
                                       options.seed, arguments.anchor);
      if (absl::Status status = writer->AddFixes(pass.name, fixes); !status.ok()) return status;
    }
    PrintPass(*simulated, options.length_m);
  }
  if (ChangesWorld(options.ageing)) {
    if (absl::Status status = writer->AddChanges(aged.changes); !status.ok()) return status;
  }
  return writer->Finish(options);
}

template <typename Kind>
CLI::Option* AddChoice(CLI::App& app, const std::string& flag, Kind& kind,
                       const std::string& description) {
  std::vector<std::string> names;
  for (const auto& [name, value] : NamesFor(Kind{})) names.emplace_back(name);
  const auto take = [&kind](const std::string& text) {
    for (const auto& [name, value] : NamesFor(Kind{})) {
      if (text == name) kind = value;
    }
  };
  return app.add_option_function<std::string>(flag, take, description)
      ->check(CLI::IsMember(names).description(""))
      ->type_name(absl::StrJoin(names, "|"))
      ->default_str(NameOf(kind));
}

void AddWorldOptions(CLI::App& app, SimulateArguments& arguments) {
  SimulationOptions& options = arguments.options;
  AddChoice(app, "--world", options.world, "Where to drive");
  app.add_option("--seed", options.seed, "Makes another world of the kind, and other drives");
  app.add_option("--length-m", options.length_m, "Length of each drive")->type_name("M");
  app.add_option("--tunnel-m", options.tunnel_m,
                 "Length of a tunnel in the middle, whose walls show nothing of the way along it")
      ->type_name("M");
  app.add_option("--loop-m", options.loop_m,
                 "Make the town's street a ring of about this length; drives begin at different "
                 "places of it. 0 for a street with two ends")
      ->type_name("M");
  app.add_flag("--both-ways", options.both_ways,
               "On a ring, every second drive goes the other way round");
  app.add_option("--map-speed-kmh", arguments.map_speed_kmh,
                 "Mean speed of the map pass, where bends allow it")
      ->type_name("KMH");
  app.add_option("--live-speed-kmh", arguments.live_speeds_kmh,
                 "Mean speeds of the live passes, comma-separated: one pass each")
      ->delimiter(',')
      ->type_name("KMH,...");
  app.add_flag("--stops", options.stops, "Halt at about every other crossroads");
  app.add_option("--parked-change", options.parked_change_share,
                 "Share of the parked vehicles that is gone or replaced in live passes")
      ->type_name("SHARE");
}

void AddAgeingOptions(CLI::App& app, SimulationOptions& options) {
  simulation::AgeingOptions& ageing = options.ageing;
  app.add_option("--day", options.day,
                 "Day of the map pass: other drives, traffic and parked vehicles in the same world")
      ->type_name("DAY");
  app.add_option("--vehicles", options.vehicle_count,
                 "Vehicles that drive in turn; each has its radars elsewhere, as its rig says")
      ->type_name("COUNT");
  app.add_option("--replaced", ageing.replaced_share,
                 "Share of what stands that live passes find 2 to 5 m from where the map pass saw "
                 "it")
      ->type_name("SHARE");
  app.add_option("--site-m", ageing.site_m,
                 "Length of a construction site at the right kerb, in live passes")
      ->type_name("M");
  app.add_option("--new-posts", ageing.post_count, "New posts at the left kerb, in live passes")
      ->type_name("COUNT");
  app.add_option("--gone-wall-m", ageing.gone_wall_m,
                 "Length of street whose houses on the left are gone in live passes")
      ->type_name("M");
  app.add_option("--leaves", ageing.leaf_count,
                 "Weak reflections that move in the wind, around each tree, in live passes")
      ->type_name("COUNT");
}

void AddRadarOptions(CLI::App& app, SimulationOptions& options) {
  AddChoice(app, "--radar", options.radar, "Kind of radar");
  AddChoice(app, "--noise", options.noise,
            "Noise of Table IV of the DC-Loc++ paper; others than gaussian need --radar carla");
  app.add_option("--noise-scale", options.noise_scale,
                 "Times that noise; the rig is described as with 1. 0 shows what else errs")
      ->type_name("X");
  app.add_flag("--flat", options.is_flat,
               "Measure as if everything stood at the radar's height, so that no range is slant");
  app.add_option("--rig", options.rig_size, "Number of radars, 1 (front) or 5")->type_name("COUNT");
  app.add_option("--scan-rate-hz", options.scan_rate_hz,
                 "Scans of each radar a second; 0 for those of its kind, 13")
      ->type_name("HZ");
  app.add_option("--beta-s", options.beta_s,
                 "Range-Doppler coupling: measured range = range + beta * range rate")
      ->type_name("S");
  app.add_flag("--elevation", options.has_elevation, "The radars measure elevation (z columns)");
  app.add_option("--unambiguous-range-rate-mps", options.unambiguous_range_rate_mps,
                 "Fold range rates into +- this; 0 for none")
      ->type_name("MPS");
  app.add_option("--range-rate-step-mps", options.range_rate_step_mps,
                 "Quantise range rates, 0.25 for an ARS408's; 0 for none")
      ->type_name("MPS");
  app.add_option("--clutter", options.clutter_share, "Share of false targets in a scan")
      ->type_name("SHARE");
  app.add_option("--ghosts", options.ghost_share, "Share of multipath ghosts in a scan")
      ->type_name("SHARE");
}

void AddFixOptions(CLI::App& app, SimulateArguments& arguments) {
  FixOptions& fixes = arguments.fixes;
  app.add_option("--fixes", fixes.rate_hz,
                 "Write position fixes at this rate into DIR/fixes/DRIVE.csv; 0 for none")
      ->type_name("HZ");
  app.add_option("--fix-sigma-m", fixes.sigma_m,
                 "Their noise along each horizontal axis; the height's is twice that")
      ->type_name("M");
  app.add_option("--fix-heading-sigma-deg", fixes.heading_sigma_deg,
                 "Noise of their heading; 0 for fixes without one")
      ->type_name("DEG");
  app.add_option("--fix-jumps", fixes.jumps_per_min, "Multipath jumps a minute, on average")
      ->type_name("COUNT");
  app.add_option("--fix-jump-m", fixes.jump_m, "Mean size of a jump, which no sigma tells")
      ->type_name("M");
  app.add_option("--fix-jump-s", fixes.jump_s, "How long a jump lasts")->type_name("S");
  app.add_option("--fix-outages", fixes.outages_per_min, "Outages a minute, on average")
      ->type_name("COUNT");
  app.add_option("--fix-outage-s", fixes.outage_s, "How long an outage lasts")->type_name("S");
  AddAnchorOption(app, arguments.anchor);
}

}  // namespace

void AddSimulateCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* simulate = app.add_subcommand(
      "simulate", "Make drives through a simulated world, with exact truth, in nuScenes' layout");
  simulate->option_defaults()->always_capture_default();
  simulate->add_option("--out", arguments->out, "Folder to write; an earlier simulation in it goes")
      ->required()
      ->type_name("DIR");
  AddWorldOptions(*simulate, *arguments);
  AddAgeingOptions(*simulate, arguments->options);
  AddRadarOptions(*simulate, arguments->options);
  AddFixOptions(*simulate, *arguments);
  simulate->add_flag("--force", arguments->force, "Write into a folder that holds other files too");
  simulate->footer(
      "The drives are scenes called map, live-0, live-1, ...\n"
      "Example, the setting of the paper's CARLA experiment:\n"
      "  dcloc simulate --out sim --radar carla --noise student --live-speed-kmh 40,60\n"
      "  dcloc map build --dataset nuscenes --root sim --drive map --out town.dclm\n"
      "Live passes may find the world changed; DIR/v1.0-sim/dcloc_changes.json says by what.\n"
      "Example, a town in which a site was fenced in, posts were set and a house is gone:\n"
      "  dcloc simulate --out aged --site-m 60 --new-posts 12 --gone-wall-m 25 --live-speed-kmh "
      "40,50\n"
      "Position fixes are in the map frame, or on the Earth where --anchor says where that lies.\n"
      "Example, a receiver with two jumps of about 20 m and an outage a minute:\n"
      "  dcloc simulate --out sim --fixes 5 --fix-jumps 2 --fix-jump-m 20 --fix-outages 1\n"
      "  dcloc localize --server localhost:50051 --map town --dataset nuscenes --root sim \\\n"
      "      --drive live-0 --fixes sim/fixes/live-0.csv --out live-0.csv");
  OnRun(*simulate, arguments, exit_code, &Simulate);
}

}  // namespace dcloc::cli
