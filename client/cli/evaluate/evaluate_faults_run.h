#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace dcloc::cli {

/// What `dcloc evaluate faults` was asked for.
struct FaultArguments {
  std::string folder;
  std::vector<std::string> only;  ///< faults, families, worlds; empty for all
  std::uint64_t seed = 1;
  int jobs = 1;
  bool quick = false;
  bool json = false;
};

/// Does what of the campaign is not done yet, prints a row for each fault (or all of it as JSON),
/// and writes the report.
absl::Status RunFaults(const FaultArguments& arguments);

}  // namespace dcloc::cli
