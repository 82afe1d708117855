#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/faults/protection_level.h"
#include "client/evaluation/robustness/tally.h"

namespace dcloc::faults {

/// What is kept of one session, or of some together.
struct Record {
  std::size_t cases = 0;
  std::size_t arrived = 0;  ///< scans given to the localizer
  /// Right, flagged, wrong, misleading, ANEES; "disturbed" is while the fault lasts. An episode is
  /// a fault that ends; `recovery_s` the time from its end until right again.
  robustness::Tally tally;
  std::size_t meanwhile_scans = 0;  ///< answered while the fault lasts
  std::size_t meanwhile_tracking = 0;
  std::vector<double> errors_m;  ///< of the answers with a pose in the map
  std::vector<double> meanwhile_errors_m;
  double longest_call_ms = 0.0;       ///< wall clock
  std::vector<std::string> failures;  ///< "world: what"
  StanfordHistogram stanford;         ///< of TRACKING answers that have a protection level
};

/// Both as one.
void Merge(const Record& other, Record& record);

/// Errors are written to a tenth of a millimetre.
nlohmann::ordered_json RecordToJson(const Record& record);

/// The inverse; nothing where `json` is not what RecordToJson writes.
std::optional<Record> RecordFromJson(const nlohmann::json& json);

}  // namespace dcloc::faults
