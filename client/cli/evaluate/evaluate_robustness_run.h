#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"

namespace dcloc::cli {

/// What `dcloc evaluate robustness` was asked for.
struct RobustnessArguments {
  std::string folder;
  std::string data;  ///< empty for simulated drives alone
  std::uint64_t seed = 1;
  bool quick = false;
};

/// Does the trials of the campaign that are not finished, prints the tables and the goals, and
/// writes the report.
absl::Status RunRobustness(const RobustnessArguments& arguments);

}  // namespace dcloc::cli
