#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace dcloc::faults {

/// Errors against protection levels, counted in cells of a tenth of a decade: a Stanford diagram.
struct StanfordHistogram {
  static constexpr int kCellsPerDecade = 10;

  /// By (cell of the error, cell of the level): cell i holds what is from 10^(i / 10) m on.
  std::map<std::pair<int, int>, std::size_t> counts;
  std::size_t answers = 0;
  std::size_t exceeded = 0;  ///< answers whose error is above their protection level

  /// `level_m` > 0; both are brought into [1 mm, 1 km] for their cells.
  void Add(double error_m, double level_m);
};

/// Both as one.
void Merge(const StanfordHistogram& other, StanfordHistogram& histogram);

nlohmann::ordered_json StanfordToJson(const StanfordHistogram& histogram);

/// The inverse; throws nlohmann::json::exception where `json` is not what StanfordToJson writes.
StanfordHistogram StanfordFromJson(const nlohmann::json& json);

}  // namespace dcloc::faults
