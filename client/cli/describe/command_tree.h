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

/// The last one of a command's names: "build" of "map build".
std::string LastName(const std::string& path);

/// All but the last one: "map" of "map build", "" of "map".
std::string ParentPath(const std::string& path);

}  // namespace dcloc::cli
