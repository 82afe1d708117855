#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "client/evaluation/paper/comparison.h"

namespace dcloc::paper {

/// Rows of text, the first being the header.
using TextTable = std::vector<std::vector<std::string>>;

/// One table of the study: of the paper's tables, over one set, by one protocol.
struct StudyTable {
  std::string id;       ///< of the paper's table: "table-1", ...
  std::string heading;  ///< for people
  std::string set;
  Protocol protocol = Protocol::kTrack;
  Comparison rows;
};

/// Tables I to IV over all sets, as far as there are results.
std::vector<StudyTable> StudyTables(std::span<const RunResult> results);

TextTable ComparisonText(const Comparison& rows);
nlohmann::ordered_json ToJson(const StudyTable& table);

/// The row of another method than ours where `measure`, over all scans, is smallest; nullptr where
/// none has a number.
const ComparisonRow* BestOther(const Comparison& rows,
                               const std::function<double(const Metrics&)>& measure);

/// Ours against the best of the others by each measure, a row for each Table I.
TextTable SummaryText(std::span<const StudyTable> tables);

/// What the paper says of Fig. 11: by how much mean translation errors, where all succeed, lie
/// below those of others, a row for each noise in the order of Table IV.
TextTable NoiseReductionText(std::span<const StudyTable> tables);

/// Table V: mean times of DC-Loc++ and ours by module, a row for each set.
TextTable TimesText(std::span<const StudyTable> tables);

}  // namespace dcloc::paper
