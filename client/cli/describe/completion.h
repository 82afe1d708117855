#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace dcloc::cli {

/// Scripts that complete the commands of `app`, their options, and values where an option takes
/// none but some; files elsewhere.
std::string BashCompletion(const CLI::App& app);
/// The same for zsh with what each is for. A file of it in `fpath` is loaded as it is needed; it
/// may be sourced too.
std::string ZshCompletion(const CLI::App& app);

}  // namespace dcloc::cli
