#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/config/config.h"

namespace dcloc::server {

/// What `dcloc-server` returns to the shell for wrong usage.
inline constexpr int kUsageError = 2;

/// What the program was asked to do.
struct CommandLine {
  std::optional<std::string> print;  ///< only print this: help or version
  bool check_config = false;         ///< only say whether the settings are valid
  ServerConfig config;
};

/// Parses the flags, which override the file of --config, which overrides the defaults.
/// InvalidArgument names what is wrong.
absl::StatusOr<CommandLine> ParseCommandLine(int argc, const char* const* argv);

}  // namespace dcloc::server
