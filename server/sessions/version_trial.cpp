#include "server/sessions/version_trial.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dcloc::server {
namespace {

std::vector<double> SharesOf(const VersionTally& tally, int min_looks) {
  std::vector<double> shares;
  for (const auto& [vehicle, count] : tally) {
    if (count.looks < min_looks) continue;
    shares.push_back(static_cast<double>(count.tracking) / count.looks);
  }
  return shares;
}

double Mean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// By how many standard deviations `a` ranks below `b`, if both were alike; equal values share
/// their ranks.
double SigmasBelow(const std::vector<double>& a, const std::vector<double>& b) {
  struct Value {
    double value;
    bool is_a;
  };
  std::vector<Value> all;
  for (const double value : a) all.push_back({value, true});
  for (const double value : b) all.push_back({value, false});
  std::ranges::sort(all, {}, &Value::value);
  double rank_sum_a = 0.0;
  double ties = 0.0;
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin + 1;
    while (end < all.size() && all[end].value == all[begin].value) ++end;
    const double rank = 0.5 * static_cast<double>(begin + 1 + end);
    for (std::size_t i = begin; i < end; ++i) rank_sum_a += all[i].is_a ? rank : 0.0;
    const auto count = static_cast<double>(end - begin);
    ties += count * (count * count - 1.0);
    begin = end;
  }
  const auto n_a = static_cast<double>(a.size());
  const auto n_b = static_cast<double>(b.size());
  const double n = n_a + n_b;
  const double variance = n_a * n_b / 12.0 * (n + 1.0 - ties / (n * (n - 1.0)));
  if (variance <= 0.0) return 0.0;
  return (0.5 * n_a * (n + 1.0) - rank_sum_a) / std::sqrt(variance);
}

}  // namespace

Trial CompareVersions(const VersionTally& canary, const VersionTally& active,
                      const TrialOptions& options) {
  const std::vector<double> canary_shares = SharesOf(canary, options.min_looks);
  const std::vector<double> active_shares = SharesOf(active, options.min_looks);
  Trial trial{.canary_vehicles = canary_shares.size(),
              .active_vehicles = active_shares.size(),
              .canary_share = Mean(canary_shares),
              .active_share = Mean(active_shares)};
  const auto least = static_cast<std::size_t>(options.min_vehicles);
  if (trial.canary_vehicles < least || trial.active_vehicles < least) return trial;
  trial.sigmas = SigmasBelow(canary_shares, active_shares);
  trial.is_canary_worse = trial.sigmas >= options.min_sigmas &&
                          trial.active_share - trial.canary_share >= options.min_share_lost;
  return trial;
}

}  // namespace dcloc::server
