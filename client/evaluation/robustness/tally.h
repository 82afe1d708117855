#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dcloc::robustness {

/// An answer or an episode that deserves a look.
struct Incident {
  std::string what;   ///< "misleading", "wrong", "slow recovery", "wrong claim", "no claim"
  std::string drive;  ///< the live drive
  double at_s = 0.0;  ///< since the drive's first scan
  double error_m = 0.0;
  double error_deg = 0.0;
  double nees = 0.0;   ///< over three degrees of freedom with planar radars
  double for_s = 0.0;  ///< how long it took, or lasted
};

/// Counts over sessions, which can be added. Scans are sorted into right, flagged and wrong, so
/// that these three add up to `scans`.
struct Tally {
  std::size_t scans = 0;
  std::size_t right = 0;       ///< answered within 2 m and 5 degrees, in whatever state
  std::size_t flagged = 0;     ///< not right, and not called tracking either
  std::size_t wrong = 0;       ///< not right, but called tracking
  std::size_t misleading = 0;  ///< of the wrong ones, as METHOD section 8 counts
  std::size_t tracking = 0;
  std::size_t refused = 0;

  double worst_tracking_m = 0.0;  ///< largest error that was called tracking
  double nees_per_dof_sum = 0.0;  ///< of the answered ones
  std::size_t nees_count = 0;
  std::size_t inside_95 = 0;
  double disturbed_nees_per_dof_sum = 0.0;  ///< of those within a disturbance alone
  std::size_t disturbed_nees_count = 0;
  std::size_t disturbed_inside_95 = 0;

  std::size_t episodes = 0;        ///< disturbances after which there was data
  std::vector<double> recovery_s;  ///< of those after which tracking came back
  std::size_t starts = 0;
  std::vector<double> right_claim_s;  ///< data before each first answer that was rightly tracking
  std::size_t wrong_claims = 0;  ///< first answers that were called tracking and were not right

  std::vector<Incident> incidents;  ///< at most kMaxIncidents

  static constexpr std::size_t kMaxIncidents = 200;
  void Add(Incident incident);
};

/// Both as one.
void Merge(const Tally& other, Tally& tally);

/// Quantile by nearest rank of `count` values of which those missing in `values` are infinite; NaN
/// when `count` is 0.
double QuantileOf(std::vector<double> values, std::size_t count, double quantile);

/// The share of `count` that is in `values` and at most `limit`; NaN when `count` is 0.
double ShareWithin(const std::vector<double>& values, std::size_t count, double limit);

nlohmann::ordered_json TallyToJson(const Tally& tally);

/// The inverse; nothing where `json` is not what `TallyToJson` writes.
std::optional<Tally> TallyFromJson(const nlohmann::json& json);

}  // namespace dcloc::robustness
