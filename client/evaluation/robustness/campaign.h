#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/evaluation/result_store.h"
#include "client/evaluation/robustness/trials.h"

namespace dcloc::robustness {

/// A question that the campaign asks; its trials at all sites are reported together.
struct Row {
  const char* id;  ///< fit for file names
  const char* label;
  bool is_start = false;     ///< of starts rather than of whole drives
  bool is_recorded = false;  ///< of recordings rather than of simulated drives
};

/// In the order in which they are reported.
inline constexpr std::array<Row, 15> kRows = {
    {{"undisturbed", "undisturbed"},
     {"outliers", "10 scans, 60 % outliers"},
     {"displaced", "10 scans, displaced copy"},
     {"empty", "10 empty scans"},
     {"gap", "2 s without data"},
     {"tunnel", "tunnel of 300 m"},
     {"recorded-1m", "recordings, from 1 m / 2 deg", false, true},
     {"recorded-3m", "recordings, from 3 m / 5 deg", false, true},
     {"recorded-5m", "recordings, from 5 m / 10 deg", false, true},
     {"start-3m", "from 3 m / 5 deg", true},
     {"start-5m", "from 5 m / 10 deg", true},
     {"start-gnss", "from a GNSS fix of 3 m, no heading", true},
     {"start-none", "from nothing", true},
     {"recorded-start-gnss", "recordings, from a GNSS fix of 3 m, no heading", true, true},
     {"recorded-start-none", "recordings, from nothing", true, true}}};

/// A map, a live drive, and what is tried there.
struct Site {
  std::string name;  ///< unique; letters, digits, '-', '_' and '+'
  std::function<absl::StatusOr<Course>()> load;
  std::vector<std::pair<std::string, Trial>> trials;  ///< each with the id of its row
};

struct TrialResult {
  std::string site;
  std::string row;
  Tally tally;
};

using TallyStore = ResultStore<Tally>;

/// Does all trials of all sites that `store` does not hold, and loads the drives of no other site.
/// `progress` receives what is being done and the share of the trials done. Errors name the trial.
absl::StatusOr<std::vector<TrialResult>> RunCampaign(
    const std::vector<Site>& sites, TallyStore& store,
    const std::function<void(const std::string&, double)>& progress);

}  // namespace dcloc::robustness
