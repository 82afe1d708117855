#include "core/update/detection_model.h"

#include <algorithm>
#include <numeric>

namespace dcloc {
namespace {

constexpr int kRounds = 8;
constexpr std::size_t kClassCount = 8;
// Hits that are taken for granted in each sum, so that few landmarks do not make extremes.
constexpr double kPriorHits = 2.0;
constexpr double kFirstRate = 0.05;

double MeanRate(std::span<const PassSightings> passes) {
  double hits = 0.0;
  double looks = 0.0;
  for (const PassSightings& pass : passes) {
    for (std::size_t i = 0; i < pass.hits.size(); ++i) {
      hits += pass.hits[i];
      looks += std::accumulate(pass.exposures[i].begin(), pass.exposures[i].end(), 0.0);
    }
  }
  return looks > 0.0 && hits > 0.0 ? hits / looks : kFirstRate;
}

}  // namespace

DetectionModel::DetectionModel(std::span<const PassSightings> passes,
                               std::span<const Exposure> base, std::span<const int> base_scans,
                               std::span<const double> presence)
    : passes_(passes), class_of_(base.size(), 0), strength_(base.size(), 1.0) {
  Rates first;
  first.fill(MeanRate(passes));
  rates_.assign(passes.size(), first);
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t pass = 0; pass < passes.size(); ++pass) LearnRates(pass, presence);
    if (round == kRounds / 2) ClassifyByBase(base, base_scans);
    LearnStrengths(presence);
  }
}

double DetectionModel::Sum(std::size_t pass, const Exposure& exposure) const {
  double sum = 0.0;
  for (std::size_t bin = 0; bin < kExposureBinCount; ++bin) {
    if (exposure[bin] > 0) sum += rates_[pass][bin] * exposure[bin];
  }
  return sum;
}

// One step of expectation maximization: each hit is shared out among the looks that may have been
// it.
void DetectionModel::LearnRates(std::size_t pass, std::span<const double> presence) {
  const PassSightings& sightings = passes_[pass];
  const double mean_rate = MeanRate(passes_.subspan(pass, 1));
  Rates hits{};
  Rates looks{};
  for (std::size_t i = 0; i < sightings.hits.size(); ++i) {
    const double expected = ExpectedHits(pass, i);
    if (expected <= 0.0) continue;
    const double per_expected = presence[i] * sightings.hits[i] / expected;
    for (std::size_t bin = 0; bin < kExposureBinCount; ++bin) {
      const double look = strength_[i] * sightings.exposures[i][bin];
      if (look == 0.0) continue;
      hits[bin] += per_expected * rates_[pass][bin] * look;
      looks[bin] += presence[i] * look;
    }
  }
  for (std::size_t bin = 0; bin < kExposureBinCount; ++bin) {
    rates_[pass][bin] =
        (hits[bin] + kPriorHits * 0.1) / (looks[bin] + kPriorHits * 0.1 / mean_rate);
  }
}

void DetectionModel::ClassifyByBase(std::span<const Exposure> base,
                                    std::span<const int> base_scans) {
  std::vector<double> strength(base.size());
  double hits = 0.0;
  double expected = 0.0;
  for (std::size_t i = 0; i < base.size(); ++i) {
    strength[i] = Sum(0, base[i]);
    hits += base_scans[i];
    expected += strength[i];
  }
  const double scale = expected > 0.0 ? hits / expected : 1.0;
  for (std::size_t i = 0; i < base.size(); ++i) {
    strength[i] = (1.0 + base_scans[i]) / (1.0 + scale * strength[i]);
  }
  std::vector<std::size_t> order(base.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return strength[i]; });
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    class_of_[order[rank]] = rank * kClassCount / order.size();
  }
}

void DetectionModel::LearnStrengths(std::span<const double> presence) {
  std::array<double, kClassCount> hits{};
  std::array<double, kClassCount> expected{};
  for (std::size_t pass = 0; pass < passes_.size(); ++pass) {
    for (std::size_t i = 0; i < class_of_.size(); ++i) {
      hits[class_of_[i]] += presence[i] * passes_[pass].hits[i];
      expected[class_of_[i]] += presence[i] * Sum(pass, passes_[pass].exposures[i]);
    }
  }
  for (std::size_t i = 0; i < class_of_.size(); ++i) {
    strength_[i] = (hits[class_of_[i]] + kPriorHits) / (expected[class_of_[i]] + kPriorHits);
  }
}

}  // namespace dcloc
