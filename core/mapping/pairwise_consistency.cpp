#include "core/mapping/pairwise_consistency.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dcloc {
namespace {

enum class Verdict { kUnrelated, kAgrees, kDisagrees };

double PathLengthBetween(const SurveyGraph& graph, std::size_t a, std::size_t b) {
  return std::abs(graph.node(a).arc_length_m - graph.node(b).arc_length_m);
}

// The path around: over `a`, along the drive of the one ends, back over `b`, along the other drive.
Verdict Compare(const SurveyEdge& a, const SurveyEdge& b, const SurveyGraph& graph,
                const PairwiseConsistencyOptions& options) {
  if (graph.IndexOf(a.from).drive != graph.IndexOf(b.from).drive ||
      graph.IndexOf(a.to).drive != graph.IndexOf(b.to).drive) {
    return Verdict::kUnrelated;
  }
  const double path_from_m = PathLengthBetween(graph, a.from, b.from);
  const double path_to_m = PathLengthBetween(graph, a.to, b.to);
  if (path_from_m > options.max_separation_m || path_to_m > options.max_separation_m)
    return Verdict::kUnrelated;
  const std::vector<Pose2>& T = graph.T_map_nodes;
  const Pose2 around = a.T_from_to.pose * (T[a.to].Inverse() * T[b.to]) *
                       b.T_from_to.pose.Inverse() * (T[b.from].Inverse() * T[a.from]);
  const double path_length_m = path_from_m + path_to_m;
  const bool closes = around.translation_m.norm() <=
                          options.tolerance_m + options.tolerance_share * path_length_m &&
                      std::abs(WrapAngle(around.yaw_rad)) <=
                          options.tolerance_rad + options.tolerance_rad_per_m * path_length_m;
  return closes ? Verdict::kAgrees : Verdict::kDisagrees;
}

}  // namespace

std::span<const OptionField<PairwiseConsistencyOptions>> FieldsOf(
    const PairwiseConsistencyOptions& /*options*/) {
  using O = PairwiseConsistencyOptions;
  static constexpr OptionField<O> kFields[] = {
      {"max_separation_m", &O::max_separation_m, 1, 10'000},
      {"tolerance_m", &O::tolerance_m, 0.01, 100},
      {"tolerance_share", &O::tolerance_share, 1e-4, 1},
      {"tolerance_rad", &O::tolerance_rad, 1e-4, 3},
      {"tolerance_rad_per_m", &O::tolerance_rad_per_m, 1e-6, 1},
      {"min_support", &O::min_support, 1, 100},
      {"max_conflict_share", &O::max_conflict_share, 1e-3, 1},
  };
  return kFields;
}

absl::Status Validate(const PairwiseConsistencyOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

std::vector<SurveyEdge> ConfirmedLoops(const std::vector<SurveyEdge>& candidates,
                                       const SurveyGraph& graph,
                                       const PairwiseConsistencyOptions& options) {
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return candidates[i].to; });
  std::vector<int> support(candidates.size(), 0);
  std::vector<int> conflict(candidates.size(), 0);
  for (std::size_t a = 0; a < order.size(); ++a) {
    for (std::size_t b = a + 1; b < order.size(); ++b) {
      const SurveyEdge& one = candidates[order[a]];
      const SurveyEdge& other = candidates[order[b]];
      if (graph.IndexOf(one.to).drive != graph.IndexOf(other.to).drive ||
          PathLengthBetween(graph, one.to, other.to) > options.max_separation_m) {
        break;
      }
      const Verdict verdict = Compare(one, other, graph, options);
      if (verdict == Verdict::kUnrelated) continue;
      std::vector<int>& tally = verdict == Verdict::kAgrees ? support : conflict;
      ++tally[order[a]];
      ++tally[order[b]];
    }
  }
  std::vector<SurveyEdge> confirmed;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double compared = support[i] + conflict[i];
    if (support[i] >= options.min_support && conflict[i] <= options.max_conflict_share * compared) {
      confirmed.push_back(candidates[i]);
    }
  }
  return confirmed;
}

}  // namespace dcloc
