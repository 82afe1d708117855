#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "client/evaluation/paper/tables.h"

namespace dcloc::paper {

/// One goal of dcloc on one set: a number that is to lie within bounds.
struct Goal {
  std::string what;    ///< "RTE median [m]": a column
  std::string set;     ///< with protocol and rig: a row
  double value = 0.0;  ///< NaN where the set gives no number, which meets nothing
  double low = 0.0, high = 0.0;
  int digits = 3;      ///< to print
  std::string detail;  ///< beside the number, or empty

  bool met() const { return value >= low && value <= high; }
};

/// What dcloc is to reach, as far as `results` can tell. `tables` are those of the same results.
std::vector<Goal> Goals(std::span<const RunResult> results, std::span<const StudyTable> tables);

/// A row for each set, a column for each goal: the number and whether it is met.
TextTable GoalsText(std::span<const Goal> goals);

/// The same as an array; a missing number is null.
nlohmann::ordered_json GoalsJson(std::span<const Goal> goals);

}  // namespace dcloc::paper
