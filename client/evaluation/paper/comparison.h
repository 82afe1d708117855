#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/evaluation/metrics.h"
#include "client/evaluation/paper/statistics.h"
#include "client/evaluation/paper/study.h"
#include "client/evaluation/paper/table_rows.h"

namespace dcloc::paper {

struct ComparisonRow {
  RowPlan plan;
  Metrics common;  ///< over the scans on which every row's variant succeeded: the paper's
  Metrics all;     ///< over all scans
  Slope slope;
};

/// One table: variants over the same cases.
using Comparison = std::vector<ComparisonRow>;

/// The sets of `results` in the order of their first case.
std::vector<std::string> SetsOf(std::span<const RunResult> results);

/// The outcomes of `variant` over the cases of `set` ("simulated" stands for all sets whose name
/// begins so), by case.
std::vector<const RunResult*> ResultsOf(std::span<const RunResult> results, const std::string& set,
                                        const Variant& variant, Protocol protocol);

/// Fills the table from those cases of `set` that all rows' variants ran; rows whose variant ran
/// none are left out, and a table with fewer than two rows is none.
std::optional<Comparison> Compare(std::span<const RunResult> results, const std::string& set,
                                  Protocol protocol, std::vector<RowPlan> plans);

}  // namespace dcloc::paper
