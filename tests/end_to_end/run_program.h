#pragma once

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "absl/status/status.h"
#include "absl/strings/str_format.h"

namespace dcloc {

/// What a program's main returns: `run`'s exit status, or failure with the message of what the
/// standard library throws.
inline int RunProgram(int (*run)(int, char**), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fputs(error.what(), stderr);
    return EXIT_FAILURE;
  }
}

/// Runs a campaign and lets it report. If it fails, says so with the seed that repeats it.
template <typename Campaign>
int RunCampaign(Campaign& campaign, unsigned seed) {
  const absl::Status status = campaign.Run();
  if (!status.ok()) {
    absl::FPrintF(stderr, "%s (seed %d)\n", status.message(), seed);
    return EXIT_FAILURE;
  }
  campaign.Report();
  return EXIT_SUCCESS;
}

}  // namespace dcloc
