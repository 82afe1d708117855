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

double Share(double prior, double sum, double count) {
  return std::clamp((prior * kPriorCount + sum) / (kPriorCount + count), 0.005, 0.6);
}

void FitShares(Places known, Places found, const PresenceModel& prior, PresenceModel& model) {
  double went = 0.0;
  double changing = 0.0;
  for (const auto& passes : known) {
    const Presence presence = JudgeKnown(passes, model);
    went += presence.went;
    changing += presence.comes_and_goes;
  }
  double never = 0.0;
  for (const auto& passes : found) {
    const Presence presence = JudgeNew(passes, model);
    changing += presence.comes_and_goes;
    never += presence.never;
  }
  const auto known_count = static_cast<double>(known.size());
  const auto found_count = static_cast<double>(found.size());
  model.went_before = Share(prior.went_before, went, known_count);
  model.comes_and_goes = Share(prior.comes_and_goes, changing, known_count + found_count);
  model.never = std::min(Share(prior.never, never, found_count), 0.9 - model.comes_and_goes);
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
