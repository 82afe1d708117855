#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/mapping/survey_graph.h"
#include "core/mapping/survey_graph_solver.h"
#include "core/options/option_fields.h"

namespace dcloc {

/// When two loops agree, and how many must.
struct PairwiseConsistencyOptions {
  /// Loops are compared where both of their ends lie within this distance along a drive each.
  double max_separation_m = 150.0;
  /// Two loops agree when the cycle over both of them closes within this, and within the shares of
  /// the distance driven between their ends.
  double tolerance_m = 0.6;
  double tolerance_share = 0.01;
  double tolerance_rad = 0.02;
  double tolerance_rad_per_m = 1e-4;
  int min_support = 2;               ///< loops that agree
  double max_conflict_share = 0.34;  ///< of the compared ones may disagree
};
std::span<const OptionField<PairwiseConsistencyOptions>> FieldsOf(
    const PairwiseConsistencyOptions& options);
absl::Status Validate(const PairwiseConsistencyOptions& options);

/// The loops of `candidates` that enough others confirm: a wrong registration is rarely wrong in
/// the same way twice (pairwise consistency, Mangelson et al., ICRA 2018). The paths between their
/// ends are those of `graph`.
std::vector<SurveyEdge> ConfirmedLoops(const std::vector<SurveyEdge>& candidates,
                                       const SurveyGraph& graph,
                                       const PairwiseConsistencyOptions& options);

/// The largest set, by greedy choice, of items that all agree pairwise; indices ascend.
/// `agrees(i, j)` is symmetric.
template <typename Agrees>
std::vector<std::size_t> ConsistentSet(std::size_t count, const Agrees& agrees) {
  std::vector<std::size_t> best;
  for (std::size_t first = 0; first < count; ++first) {
    std::vector<std::size_t> set;
    for (std::size_t step = 0; step < count; ++step) {
      const std::size_t i = (first + step) % count;
      bool fits = true;
      for (const std::size_t member : set) fits = fits && agrees(member, i);
      if (fits) set.push_back(i);
    }
    if (set.size() > best.size()) best = set;
  }
  std::ranges::sort(best);
  return best;
}

}  // namespace dcloc
