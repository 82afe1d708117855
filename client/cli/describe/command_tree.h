#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace dcloc::cli {

/// Subcommands with a name; option groups have none.
std::vector<const CLI::App*> CommandsOf(const CLI::App& app);

/// A command's own options and those of its groups.
std::vector<const CLI::Option*> OptionsOf(const CLI::App& app);

/// Calls `visit(app, "")` and then `visit(command, "map build")` for each command below it, with
/// all of its names.
void ForEachCommand(const CLI::App& app,
                    const std::function<void(const CLI::App&, const std::string&)>& visit);

/// "--help", "-h"; none for a positional.
std::vector<std::string> FlagsOf(const CLI::Option& option);

/// Whether a value follows the option.
bool TakesValue(const CLI::Option& option);

/// The values that the option takes, where it takes none but these; else none.
std::vector<std::string> ChoicesOf(const CLI::Option& option);

/// Calls `visit("map build --dataset", {"nuscenes", "rosbag"})` for each flag of each command, the
/// path of the program being empty, whose values are all known.
void ForEachChoice(
    const CLI::App& app,
    const std::function<void(const std::string&, const std::vector<std::string>&)>& visit);

/// A line of a shell's `case` for each command, which leads `variable` from the path of the command
/// above it and its own name to its path: "map build") path='map build' ;;
std::string PathCases(const CLI::App& app, const std::string& variable);

}  // namespace dcloc::cli
