#include "client/cli/load/load_command.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <string>

#include "client/cli/common/on_run.h"
#include "client/cli/load/load_command_run.h"
#include "client/cli/remote/server_options.h"

namespace dcloc::cli {
namespace {

constexpr double kDay_s = 86'400.0;

/// Adds an option of so many units (s, ms), each `unit_ns` long, that fills a duration.
template <typename Duration>
void AddDuration(CLI::App& command, const std::string& name, Duration& duration, double unit_ns,
                 double max, const std::string& description, const char* type_name) {
  const double value = static_cast<double>(std::chrono::nanoseconds(duration).count()) / unit_ns;
  command
      .add_option_function<double>(
          name,
          [&duration, unit_ns](double given) {
            duration = std::chrono::duration_cast<Duration>(
                std::chrono::nanoseconds(std::llround(given * unit_ns)));
          },
          description)
      ->check(CLI::Range(0.0, max))
      ->type_name(type_name)
      ->default_str(CLI::detail::to_string(value));
}

template <typename Duration>
void AddSeconds(CLI::App& command, const std::string& name, Duration& duration,
                const std::string& description) {
  AddDuration(command, name, duration, 1e9, kDay_s, description, "S");
}

template <typename Duration>
void AddMilliseconds(CLI::App& command, const std::string& name, Duration& duration,
                     const std::string& description) {
  AddDuration(command, name, duration, 1e6, 1e3 * kDay_s, description, "MS");
}

void AddRouteOptions(CLI::App& command, LoadArguments& arguments) {
  command.add_option("--map", arguments.map, "Map of the server; its active version is used")
      ->required()
      ->type_name("NAME");
  AddDatasetOptions(command, arguments.dataset);
  command
      .add_option("--drive", arguments.drives,
                  "Drives, in the map's frame; the vehicles share them in turn")
      ->required()
      ->delimiter(',')
      ->type_name("A,B");
  AddRadarsOption(command, "--radars", arguments.radars, "Radars to send; all by default");
}

void AddPaceOptions(CLI::App& command, LoadArguments& arguments) {
  load::LoadOptions& options = arguments.options;
  command.add_option("--vehicles", options.vehicle_count, "So many at once; a search begins there")
      ->check(CLI::Range(1, 100'000))
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option_function<std::string>(
          "--loop", [&options](const std::string& loop) { options.open_loop = loop == "open"; },
          "Send when scans are due (open), or each when the one before is answered (closed)")
      ->check(CLI::IsMember({"open", "closed"}))
      ->default_str("open");
  command.add_option("--pace", options.pace, "Recorded seconds in one of ours, in the open loop")
      ->check(CLI::Range(0.01, 1000.0))
      ->type_name("X")
      ->capture_default_str();
  AddSeconds(command, "--duration-s", options.duration, "How long to measure");
  AddSeconds(command, "--ramp-s", options.ramp, "The vehicles begin one by one within it");
  AddSeconds(command, "--warmup-s", options.warmup, "Not measured, after the ramp");
  AddSeconds(command, "--drain-s", options.drain, "Wait so long for the last answers");
  AddMilliseconds(command, "--jitter-ms", options.arrival_jitter,
                  "A scan comes later by 0 to so much");
  command
      .add_option_function<std::string>(
          "--queue-policy",
          [&options](const std::string& policy) {
            options.queue_policy =
                policy == "block" ? v1::QUEUE_POLICY_BLOCK : v1::QUEUE_POLICY_DROP_OLDEST;
          },
          "What the server does with more scans than it can localize")
      ->check(CLI::IsMember({"block", "drop-oldest"}))
      ->default_str("block");
  command
      .add_option("--begin-within", options.begin_within,
                  "Share of a drive, from its start, in which vehicles begin; 0: all at the start")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("SHARE")
      ->capture_default_str();
  command.add_option("--seed", options.seed, "Of jitter, faults and where vehicles begin")
      ->type_name("N")
      ->capture_default_str();
}

void AddFaultOptions(CLI::App& command, load::FaultProfile& faults) {
  const auto add = [&command](const char* name, double& value, double max, const char* unit,
                              const char* description) {
    command.add_option(name, value, description)
        ->check(CLI::Range(0.0, max))
        ->type_name(unit)
        ->capture_default_str();
  };
  add("--disconnects-per-min", faults.disconnects_per_min, 600.0, "N",
      "Break a vehicle's connection so often; its session is resumed");
  add("--stalls-per-min", faults.stalls_per_min, 600.0, "N",
      "Let a vehicle send nothing for a while so often, then all that is due");
  AddMilliseconds(command, "--stall-ms", faults.stall_duration, "How long that lasts");
  add("--slow-readers", faults.slow_reader_share, 1.0, "SHARE",
      "Share of the vehicles that take an answer only now and then");
  AddMilliseconds(command, "--slow-read-ms", faults.slow_read_interval, "How seldom");
  add("--duplicates", faults.duplicate_share, 1.0, "SHARE", "Share of the scans sent twice");
  add("--reordered", faults.reorder_share, 1.0, "SHARE",
      "Share of the scans sent behind the one that follows");
}

void AddTargetOptions(CLI::App& command, LoadArguments& arguments) {
  CLI::Option* target =
      command
          .add_option("--target-p99-ms", arguments.target_p99_ms,
                      "Fail when 1 of 100 scans takes longer, from when it was due to its answer")
          ->check(CLI::Range(0.001, 1e6))
          ->type_name("MS");
  CLI::Option* search =
      command.add_flag("--search", arguments.search, "Find the most vehicles that hold the target")
          ->needs(target);
  command.add_option("--max-vehicles", arguments.max_vehicle_count, "The most to try")
      ->check(CLI::Range(1, 100'000))
      ->type_name("N")
      ->capture_default_str()
      ->needs(search);
  command.add_flag("--json", arguments.json, "Print as JSON");
  command.add_option("--plot", arguments.plot, "Draw latency over time")
      ->type_name("PNG")
      ->excludes(search);
}

}  // namespace

void AddLoadCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<LoadArguments>();
  CLI::App* load = app.add_subcommand(
      "load", "Load a server with many vehicles at once, check each answer, and say how it did");
  AddServerOptions(*load, arguments->server);
  AddRouteOptions(*load, *arguments);
  AddPaceOptions(*load, *arguments);
  AddFaultOptions(*load, arguments->options.faults);
  AddTargetOptions(*load, *arguments);
  load->footer(
      "Latency is from when a scan is due, so that waiting in the vehicle counts; slow readers' "
      "own\n"
      "is left out. The exit code is 1 when a scan was lost, refused or answered wrongly, or the\n"
      "target was not held.\n"
      "Examples:\n"
      "  dcloc load --server localhost:50051 --map town --dataset nuscenes --root sim \\\n"
      "      --drive live-0 --vehicles 200 --duration-s 60 --target-p99-ms 50 --plot latency.png\n"
      "  dcloc load --server localhost:50051 --map town --dataset nuscenes --root sim \\\n"
      "      --drive live-0 --search --target-p99-ms 50\n"
      "  dcloc load --server localhost:50051 --map town --dataset nuscenes --root sim \\\n"
      "      --drive live-0 --vehicles 50 --disconnects-per-min 6 --duplicates 0.02 --json");
  OnRun(*load, arguments, exit_code, &RunLoadCommand);
}

}  // namespace dcloc::cli
