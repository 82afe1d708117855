#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "client/evaluation/metrics.h"

namespace dcloc {

/// "INITIALIZING", "TRACKING", "DEAD_RECKONING", "LOST".
const char* StateName(LocalizationState state);

/// The metrics under the names of METHOD section 8; a metric without a value is null.
nlohmann::ordered_json MetricsJson(const Metrics& metrics);

/// A row of text for each metric, a column for each named set: the first row holds the names.
std::vector<std::vector<std::string>> MetricsRows(
    const std::vector<std::pair<std::string, Metrics>>& columns);

/// One line for each scan, with a header: answers, truth, errors, quality, times.
std::string ScansCsv(const std::vector<DriveOutcome>& drives);

}  // namespace dcloc
