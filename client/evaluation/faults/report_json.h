#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "client/evaluation/faults/rows.h"

namespace dcloc::faults {

/// Every fault in all worlds, in those of each kind, and in each world with its first
/// incidents.
/// Durations in s, errors in m and degrees; what never came is null.
nlohmann::ordered_json FaultJson(std::span<const FaultRows> rows,
                                 std::span<const CaseResult> results);

}  // namespace dcloc::faults
