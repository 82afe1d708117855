#include "core/update/presence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace dcloc {
namespace {

constexpr std::size_t kStrengthCount = 24;  // of g, evenly in its logarithm
constexpr double kMinStrength = 0.01;
constexpr double kMaxStrength = 8.0;
constexpr std::array<double, 5> kDayShares = {0.1, 0.3, 0.5, 0.7, 0.9};  // on which it is there

double LogNegativeBinomial(int hits, double mean, double shape) {
  if (mean <= 0.0) return hits == 0 ? 0.0 : -std::numeric_limits<double>::infinity();
  return std::lgamma(hits + shape) - std::lgamma(shape) - std::lgamma(hits + 1.0) +
         shape * std::log(shape / (shape + mean)) + hits * std::log(mean / (shape + mean));
}

double Absent(int hits, const PresenceModel& model) {
  if (hits == 0) return 1.0 - model.false_share;
  const double more = 1.0 - 1.0 / std::max(1.0 + 1e-6, model.false_hits);
  return model.false_share * (1.0 - more) * std::pow(more, hits - 1);
}

// Its own hits, and where there are none, false ones. `position_ratio` is 1 for what is not always
// the same thing: it may lie anywhere nearby.
double Present(const PassEvidence& pass, double g, double position_ratio,
               const PresenceModel& model) {
  const double mean = g * pass.expected_hits;
  const double none = std::exp(LogNegativeBinomial(0, mean, model.pass_shape));
  const double own =
      pass.hits == 0 ? 0.0 : std::exp(LogNegativeBinomial(pass.hits, mean, model.pass_shape));
  return position_ratio * own + none * Absent(pass.hits, model);
}

/// How likely the hits are by each history. `goes[t]` is of a landmark that is there before pass t
/// and not from it on, `comes[t]` the reverse; t is the count of passes where it never does.
struct Likelihoods {
  std::vector<double> goes, comes;
  double known_intermittent = 0.0;  ///< of what the base map has: the likelier the more often
  double found_intermittent = 0.0;
  double log_scale = 0.0;  ///< of all of these
};

/// Adds `weight` times the product of `before` up to each pass, and of `after` from it on.
void AddSwitches(double weight, std::span<const double> before, std::span<const double> after,
                 std::vector<double>& sums) {
  const std::size_t count = before.size();
  double product = weight;
  for (std::size_t t = 0; t <= count; ++t) {
    double rest = product;
    for (std::size_t p = t; p < count; ++p) rest *= after[p];
    sums[t] += rest;
    if (t < count) product *= before[t];
  }
}

void AddIntermittent(double weight, std::span<const double> present, std::span<const double> absent,
                     Likelihoods& sums) {
  const double shares = std::accumulate(kDayShares.begin(), kDayShares.end(), 0.0);
  for (const double share : kDayShares) {
    double product = weight;
    for (std::size_t p = 0; p < present.size(); ++p) {
      product *= share * present[p] + (1.0 - share) * absent[p];
    }
    sums.known_intermittent += share / shares * product;
    sums.found_intermittent += product / kDayShares.size();
  }
}

/// Averaged over the landmark's own strength.
Likelihoods LikelihoodsOf(std::span<const PassEvidence> passes, const PresenceModel& model) {
  const std::size_t count = passes.size();
  std::array<double, kStrengthCount> weights;
  std::array<std::vector<double>, kStrengthCount> present, other;
  std::vector<double> absent;
  for (const PassEvidence& pass : passes) absent.push_back(Absent(pass.hits, model));
  std::vector<double> largest = absent;
  for (std::size_t s = 0; s < kStrengthCount; ++s) {
    const double g = kMinStrength * std::pow(kMaxStrength / kMinStrength,
                                             (static_cast<double>(s) + 0.5) / kStrengthCount);
    // The Gamma density times g, as the strengths are even in log g.
    weights[s] = std::exp(model.strength_shape * (std::log(g) - g));
    for (std::size_t p = 0; p < count; ++p) {
      present[s].push_back(Present(passes[p], g, passes[p].position_ratio, model));
      other[s].push_back(Present(passes[p], g, 1.0, model));
      largest[p] = std::max({largest[p], present[s][p], other[s][p]});
    }
  }
  Likelihoods sums{.goes = std::vector<double>(count + 1), .comes = std::vector<double>(count + 1)};
  for (std::size_t p = 0; p < count; ++p) {
    absent[p] /= largest[p];
    sums.log_scale += std::log(largest[p]);
  }
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (std::size_t s = 0; s < kStrengthCount; ++s) {
    for (std::size_t p = 0; p < count; ++p) {
      present[s][p] /= largest[p];
      other[s][p] /= largest[p];
    }
    AddSwitches(weights[s] / total, present[s], absent, sums.goes);
    AddSwitches(weights[s] / total, absent, present[s], sums.comes);
    AddIntermittent(weights[s] / total, other[s], absent, sums);
  }
  return sums;
}

/// The probability that what lasts changes in the time before each pass, and last that it has not.
std::vector<double> ChangeTimes(std::span<const PassEvidence> passes, double changes_per_day) {
  std::vector<double> shares;
  double left = 1.0;
  for (const PassEvidence& pass : passes) {
    const double survives = std::exp(-changes_per_day * std::max(0.0, pass.days_before));
    shares.push_back(left * (1.0 - survives));
    left *= survives;
  }
  shares.push_back(left);
  return shares;
}

std::size_t MaximumAt(std::span<const double> values) {
  return static_cast<std::size_t>(std::ranges::max_element(values) - values.begin());
}

double Sum(const Presence& presence) {
  return presence.stays + presence.added + presence.removed + presence.intermittent +
         presence.never;
}

Presence Normalized(Presence presence) {
  const double total = Sum(presence);
  for (double* value : {&presence.stays, &presence.added, &presence.removed, &presence.intermittent,
                        &presence.never}) {
    *value /= total;
  }
  return presence;
}

/// Prior times likelihood of each history of a landmark of the base map.
Presence WeighKnown(const Likelihoods& likelihoods, std::span<const PassEvidence> passes,
                    const PresenceModel& model) {
  // What went before the first pass has a share of its own; later changes go by time.
  std::vector<double> lasting = ChangeTimes(passes.subspan(1), model.changes_per_day);
  for (double& share : lasting) share *= 1.0 - model.known_removed - model.known_intermittent;
  lasting.insert(lasting.begin(), model.known_removed);
  for (std::size_t t = 0; t < lasting.size(); ++t) lasting[t] *= likelihoods.goes[t];
  const std::span<const double> gone = std::span(lasting).first(passes.size());
  return {.stays = lasting.back(),
          .removed = std::accumulate(gone.begin(), gone.end(), 0.0),
          .intermittent = model.known_intermittent * likelihoods.known_intermittent,
          .since = MaximumAt(gone)};
}

/// How likely the hits of a place are by each of what a candidate may be, and `since`.
Presence LikelihoodsOfFound(const Likelihoods& likelihoods, std::span<const PassEvidence> passes,
                            const PresenceModel& model) {
  std::vector<double> added = ChangeTimes(passes, model.changes_per_day);
  const double changed = 1.0 - added.back();
  added.pop_back();
  for (std::size_t t = 0; t < added.size(); ++t) added[t] *= likelihoods.comes[t] / changed;
  return {.added = std::accumulate(added.begin(), added.end(), 0.0),
          .intermittent = likelihoods.found_intermittent,
          .never = likelihoods.comes.back(),
          .since = MaximumAt(added)};
}

}  // namespace

PresenceModel WithIntermittent(PresenceModel model, double share) {
  model.known_removed *= (1.0 - share) / (1.0 - model.known_intermittent);
  model.known_intermittent = share;
  model.found_intermittent = share * (1.0 - model.found_never);
  return model;
}

Presence PosteriorOfMapLandmark(std::span<const PassEvidence> passes, const PresenceModel& model) {
  return Normalized(WeighKnown(LikelihoodsOf(passes, model), passes, model));
}

Presence PosteriorOfCandidate(std::span<const PassEvidence> passes, const PresenceModel& model) {
  std::vector<PassEvidence> evidence(passes.begin(), passes.end());
  double& best =
      std::ranges::max_element(evidence, {}, &PassEvidence::position_ratio)->position_ratio;
  best = std::min(best, 1.0);
  Presence presence = LikelihoodsOfFound(LikelihoodsOf(evidence, model), evidence, model);
  // What no pass hits is no candidate: each history counts as far as it makes one.
  std::vector<PassEvidence> unhit = evidence;
  for (PassEvidence& pass : unhit) pass.hits = 0;
  const Likelihoods of_unhit = LikelihoodsOf(unhit, model);
  const double scale = std::exp(of_unhit.log_scale);
  const Presence none = LikelihoodsOfFound(of_unhit, passes, model);
  const double added_share = 1.0 - model.found_intermittent - model.found_never;
  presence.added *= added_share / (1.0 - scale * none.added);
  presence.intermittent *= model.found_intermittent / (1.0 - scale * none.intermittent);
  presence.never *= model.found_never / (1.0 - scale * none.never);
  return Normalized(presence);
}

double LogEvidence(std::span<const PassEvidence> passes, const PresenceModel& model) {
  const Likelihoods likelihoods = LikelihoodsOf(passes, model);
  return likelihoods.log_scale +
         std::log(std::max(1e-300, Sum(WeighKnown(likelihoods, passes, model))));
}

}  // namespace dcloc
