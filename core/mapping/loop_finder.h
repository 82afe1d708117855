#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/mapping/submap_matcher.h"
#include "core/mapping/survey_graph.h"
#include "core/options/option_fields.h"

namespace dcloc {

struct LoopFinderOptions {
  SubmapMatcherOptions matcher;
  int neighbour_count = 5;  ///< nodes before each one that it is registered with
  RegistrationGate neighbour_gate = {.min_inlier_count = 20, .min_overlap = 0.2};
  RegistrationGate loop_gate = {.min_inlier_count = 40, .min_overlap = 0.4};
  /// Nodes of one drive are a loop only over a longer path than this; before, they are neighbours.
  double min_loop_path_m = 80.0;
  double near_m = 12.0;  ///< middles of sub-maps that may show the same ground
  /// Of the times that drives pass near a node, it is registered with so many at most.
  /// Which ones differs from street to street, so that each pass is tied to many others.
  int max_visit_count = 8;
  // The standard deviation of one node from another grows with the length of the path between them.
  double base_sigma_m = 0.1;      ///< of the position, without a path
  double base_sigma_rad = 0.003;  ///< of the heading, without a path
  double drift_share = 0.005;     ///< growth of that of the position, as a share of the path
  double drift_rad_per_m = 5e-5;  ///< growth of that of the heading, per metre of path
  /// Where the deviation is larger than this, nearness says nothing: that is for place search.
  double max_sigma_m = 17.0;
  /// How many such deviations two sub-maps may be apart for a registration to be tried.
  double search_sigmas = 2.0;
  std::size_t submap_half_count = 1;  ///< nodes before and after that take part in a sub-map
  PathCosts path_costs;               ///< what joins nodes otherwise than by driving
};
std::span<const OptionField<LoopFinderOptions>> FieldsOf(const LoopFinderOptions& options);
absl::Status Validate(const LoopFinderOptions& options);

/// Finds registrations between the nodes of a survey.
class LoopFinder {
 public:
  explicit LoopFinder(const LoopFinderOptions& options = {})
      : options_(options), matcher_(options.matcher) {}

  /// Registrations of the nodes of one drive with the few before them.
  std::vector<SurveyEdge> Neighbours(const SurveyGraph& graph, std::size_t drive);

  /// Registrations of nodes that lie near one another by what is known so far, within and between
  /// drives that are joined: of every `stride`-th node, with the nearest node of each time that a
  /// drive passes there, as far as `max_visit_count` allows. None twice. `progress` gets the share
  /// done and returns whether to go on.
  std::vector<SurveyEdge> NearLoops(const SurveyGraph& graph, std::size_t stride,
                                    const std::function<bool(double)>& progress);

  /// The registration of node `to` around an expected place in the frame of node `from`.
  std::optional<SurveyEdge> Register(const SurveyGraph& graph, std::size_t from, std::size_t to,
                                     const SubmapGuess& guess, const RegistrationGate& gate);

 private:
  struct Visit {
    std::size_t node;
    double path_length_m;
    double distance_m;  // between the middles of the sub-maps
  };
  std::vector<Visit> VisitsNear(const SurveyGraph& graph, std::size_t node) const;
  std::vector<Visit> SomeOf(const std::vector<Visit>& visits, std::size_t node) const;
  double SigmaAfter(double path_length_m) const {
    return options_.base_sigma_m + options_.drift_share * path_length_m;
  }

  LoopFinderOptions options_;
  SubmapMatcher matcher_;
};

}  // namespace dcloc
