#include "client/evaluation/faults/protection_level.h"

#include <algorithm>
#include <cmath>

namespace dcloc::faults {
namespace {

int CellOf(double value_m) {
  const double decades = std::log10(std::clamp(value_m, 1e-3, 1e3));
  return static_cast<int>(std::floor(decades * StanfordHistogram::kCellsPerDecade + 1e-9));
}

}  // namespace

void StanfordHistogram::Add(double error_m, double level_m) {
  ++answers;
  if (error_m > level_m) ++exceeded;
  ++counts[{CellOf(error_m), CellOf(level_m)}];
}

void Merge(const StanfordHistogram& other, StanfordHistogram& histogram) {
  histogram.answers += other.answers;
  histogram.exceeded += other.exceeded;
  for (const auto& [cell, count] : other.counts) histogram.counts[cell] += count;
}

nlohmann::ordered_json StanfordToJson(const StanfordHistogram& histogram) {
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  for (const auto& [cell, count] : histogram.counts) {
    cells.push_back({cell.first, cell.second, count});
  }
  return {{"answers", histogram.answers}, {"exceeded", histogram.exceeded}, {"cells", cells}};
}

StanfordHistogram StanfordFromJson(const nlohmann::json& json) {
  StanfordHistogram histogram;
  histogram.answers = json.at("answers").get<std::size_t>();
  histogram.exceeded = json.at("exceeded").get<std::size_t>();
  for (const nlohmann::json& cell : json.at("cells")) {
    histogram.counts[{cell.at(0).get<int>(), cell.at(1).get<int>()}] =
        cell.at(2).get<std::size_t>();
  }
  return histogram;
}

}  // namespace dcloc::faults
