#include "core/update/presence.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dcloc {
namespace {

constexpr std::size_t kStrengths = 24;  // of g, evenly in its logarithm
constexpr double kMinStrength = 0.01;
constexpr double kMaxStrength = 8.0;
constexpr std::array<double, 5> kShares = {0.1, 0.3, 0.5, 0.7, 0.9};  // of days that it is there

double NegativeBinomial(int hits, double mean, double shape) {
  if (mean <= 0.0) return hits == 0 ? 1.0 : 0.0;
  const double log_probability =
      std::lgamma(hits + shape) - std::lgamma(shape) - std::lgamma(hits + 1.0) +
      shape * std::log(shape / (shape + mean)) + hits * std::log(mean / (shape + mean));
  return std::exp(log_probability);
}

double Absent(int hits, const PresenceModel& model) {
  if (hits == 0) return 1.0 - model.false_share;
  const double more = 1.0 - 1.0 / std::max(1.0 + 1e-6, model.false_hits);
  return model.false_share * (1.0 - more) * std::pow(more, hits - 1);
}

/// The likelihood of each history, averaged over the landmark's own strength.
struct Histories {
  double stands = 0.0;
  double never = 0.0;
  std::vector<double> goes_before;   ///< by the first pass without it
  std::vector<double> comes_before;  ///< by the first pass with it
  double comes_and_goes = 0.0;
};

class Averager {
 public:
  Averager(std::span<const PassEvidence> passes, const PresenceModel& model)
      : passes_(passes), model_(model), present_(passes.size()), absent_(passes.size()) {
    for (std::size_t p = 0; p < passes.size(); ++p) absent_[p] = Absent(passes[p].hits, model);
    result_.goes_before.assign(passes.size(), 0.0);
    result_.comes_before.assign(passes.size(), 0.0);
  }

  /// `base_share` weighs days of presence by how likely the base map then has it.
  Histories Run(bool is_known) && {
    double total = 0.0;
    for (std::size_t s = 0; s < kStrengths; ++s) {
      const double u = (static_cast<double>(s) + 0.5) / kStrengths;
      const double g = kMinStrength * std::pow(kMaxStrength / kMinStrength, u);
      // Gamma density times g, as the grid is even in log g.
      const double weight = std::exp(model_.strength_shape * (std::log(g) - g));
      total += weight;
      Add(g, weight, is_known);
    }
    Scale(1.0 / total);
    return std::move(result_);
  }

 private:
  void Add(double g, double weight, bool is_known) {
    const std::size_t count = passes_.size();
    double all = 1.0;
    double none = 1.0;
    for (std::size_t p = 0; p < count; ++p) {
      present_[p] =
          NegativeBinomial(passes_[p].hits, g * passes_[p].expected_hits, model_.pass_shape);
      all *= present_[p];
      none *= absent_[p];
    }
    result_.stands += weight * all;
    result_.never += weight * none;
    for (std::size_t tau = 0; tau < count; ++tau) {
      double goes = weight;
      double comes = weight;
      for (std::size_t p = 0; p < count; ++p) {
        goes *= p < tau ? present_[p] : absent_[p];
        comes *= p < tau ? absent_[p] : present_[p];
      }
      result_.goes_before[tau] += goes;
      result_.comes_before[tau] += comes;
    }
    result_.comes_and_goes += weight * Mixed(is_known);
  }

  double Mixed(bool is_known) const {
    double sum = 0.0;
    double total = 0.0;
    for (const double share : kShares) {
      double product = is_known ? share : 1.0;
      total += product;
      for (std::size_t p = 0; p < passes_.size(); ++p) {
        product *= share * present_[p] + (1.0 - share) * absent_[p];
      }
      sum += product;
    }
    return sum / total;
  }

  void Scale(double factor) {
    result_.stands *= factor;
    result_.never *= factor;
    result_.comes_and_goes *= factor;
    for (double& value : result_.goes_before) value *= factor;
    for (double& value : result_.comes_before) value *= factor;
  }

  std::span<const PassEvidence> passes_;
  const PresenceModel& model_;
  std::vector<double> present_, absent_;
  Histories result_;
};

std::size_t ArgMax(const std::vector<double>& values) {
  return static_cast<std::size_t>(std::ranges::max_element(values) - values.begin());
}

double Sum(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

Presence Normalized(Presence presence) {
  const double total =
      presence.stays + presence.came + presence.went + presence.comes_and_goes + presence.never;
  if (total <= 0.0) return {.comes_and_goes = 1.0};
  for (double* value : {&presence.stays, &presence.came, &presence.went, &presence.comes_and_goes,
                        &presence.never}) {
    *value /= total;
  }
  return presence;
}

}  // namespace

namespace {

/// Prior times likelihood of each history of a landmark of the base map.
Presence WeighKnown(std::span<const PassEvidence> passes, const PresenceModel& model) {
  Histories histories = Averager(passes, model).Run(true);
  double survives = (1.0 - model.comes_and_goes) * (1.0 - model.went_before);
  for (std::size_t p = 0; p < passes.size(); ++p) {
    double dies = (1.0 - model.comes_and_goes) * model.went_before;
    if (p > 0) {
      dies = survives * (1.0 - std::exp(-model.gone_per_day * passes[p].days_before));
      survives -= dies;
    }
    histories.goes_before[p] *= dies;
  }
  return {.stays = survives * histories.stands,
          .went = Sum(histories.goes_before),
          .comes_and_goes = model.comes_and_goes * histories.comes_and_goes,
          .since = ArgMax(histories.goes_before)};
}

}  // namespace

Presence JudgeKnown(std::span<const PassEvidence> passes, const PresenceModel& model) {
  return Normalized(WeighKnown(passes, model));
}

Presence JudgeNew(std::span<const PassEvidence> passes, const PresenceModel& model) {
  Histories histories = Averager(passes, model).Run(false);
  const double comes = 1.0 - model.comes_and_goes - model.never;
  double later = 0.0;
  for (std::size_t p = 1; p < passes.size(); ++p) {
    const double born = comes * (1.0 - std::exp(-model.gone_per_day * passes[p].days_before));
    histories.comes_before[p] *= born;
    later += born;
  }
  if (!passes.empty()) histories.comes_before[0] *= std::max(0.0, comes - later);
  return Normalized({.came = Sum(histories.comes_before),
                     .comes_and_goes = model.comes_and_goes * histories.comes_and_goes,
                     .never = model.never * histories.never,
                     .since = ArgMax(histories.comes_before)});
}

double LogEvidence(std::span<const PassEvidence> passes, const PresenceModel& model) {
  const Presence weights = WeighKnown(passes, model);
  return std::log(std::max(1e-300, weights.stays + weights.went + weights.comes_and_goes));
}

}  // namespace dcloc
