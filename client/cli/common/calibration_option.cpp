#include "client/cli/common/calibration_option.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace dcloc::cli {
namespace {

// The names in CalibrationParameter's order.
constexpr std::array<const char*, 4> kNames = {"beta", "time", "range", "yaw"};

}  // namespace

void AddKeepOption(CLI::App& app, KeptParameters& kept) {
  app.add_option("--keep", kept, "What is known of the radars for sure, and not estimated")
      ->delimiter(',')
      ->check(CLI::IsMember(std::vector<std::string>(kNames.begin(), kNames.end())));
}

CalibratorOptions OptionsOf(const KeptParameters& kept, CalibratorOptions options) {
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (std::ranges::find(kept, kNames.at(i)) != kept.end()) options.prior_sigma.at(i) = 0.0;
  }
  return options;
}

}  // namespace dcloc::cli
