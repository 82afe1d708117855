#include "core/update/presence_fit.h"

#include <algorithm>
#include <array>
#include <limits>

namespace dcloc {
namespace {

constexpr std::array<double, 5> kStrengthShapes = {0.4, 0.7, 1.2, 2.0, 4.0};
constexpr std::array<double, 5> kPassShapes = {0.5, 1.0, 2.0, 4.0, 8.0};
constexpr int kFitRounds = 4;
constexpr double kPriorCount = 20.0;  // of landmarks, that pull shares towards the model's

using Places = std::span<const std::vector<PassEvidence>>;

void FitShapes(Places known, PresenceModel& model) {
  PresenceModel best = model;
  double best_sum = -std::numeric_limits<double>::infinity();
  for (const double strength_shape : kStrengthShapes) {
    for (const double pass_shape : kPassShapes) {
      PresenceModel trial = model;
      trial.strength_shape = strength_shape;
      trial.pass_shape = pass_shape;
      double sum = 0.0;
      for (const auto& passes : known) sum += LogEvidence(passes, trial);
      if (sum <= best_sum) continue;
      best_sum = sum;
      best = trial;
    }
  }
  model = best;
}

/// The share of `sum` in `count`, with `kPriorCount` more that are as the prior says.
double Share(double prior, double sum, std::size_t count) {
  return (prior * kPriorCount + sum) / (kPriorCount + static_cast<double>(count));
}

// One step of expectation maximization.
void FitShares(Places known, Places found, const PresenceModel& prior, PresenceModel& model) {
  double removed = 0.0;
  double known_changing = 0.0;
  for (const auto& passes : known) {
    const Presence presence = PosteriorOfMapLandmark(passes, model);
    removed += presence.removed;
    known_changing += presence.intermittent;
  }
  double never = 0.0;
  double found_changing = 0.0;
  for (const auto& passes : found) {
    const Presence presence = PosteriorOfCandidate(passes, model);
    never += presence.never;
    found_changing += presence.intermittent;
  }
  model.known_removed = Share(prior.known_removed, removed, known.size());
  model.known_intermittent = Share(prior.known_intermittent, known_changing, known.size());
  model.found_intermittent = Share(prior.found_intermittent, found_changing, found.size());
  model.found_never = Share(prior.found_never, never, found.size());
}

}  // namespace

PresenceModel FitPresence(Places known, Places found, const PresenceModel& model) {
  PresenceModel fitted = model;
  for (int round = 0; round < kFitRounds; ++round) {
    FitShares(known, found, model, fitted);
    if (round == 1) FitShapes(known, fitted);
  }
  return fitted;
}

}  // namespace dcloc
