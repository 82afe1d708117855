#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace dcloc::cli {

/// Files that a command makes and does not replace unless it is told to.
struct OutputFiles {
  std::vector<std::string> paths;
  bool force = false;
};

/// Adds --force, which lets the command replace files.
void AddForceOption(CLI::App& command, bool& force);

/// OK when every file may be written: AlreadyExists names one that is there, without `force`;
/// InvalidArgument a path that two of the files have. Before a command does its work.
absl::Status CheckOutputFiles(const OutputFiles& files);

}  // namespace dcloc::cli
