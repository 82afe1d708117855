#pragma once

#include <algorithm>

namespace dcloc {

/// Mean and variance of values that are forgotten exponentially. Until as many have come as are
/// remembered, all count alike.
struct ForgettingMean {
  double mean = 0.0;
  double variance = 0.0;
  int count = 0;  ///< of values so far

  /// Takes in a value. `forgetting_factor` is the weight of an older one beside the next, [0, 1).
  void Add(double value, double forgetting_factor) {
    ++count;
    const double share = std::max(1.0 - forgetting_factor, 1.0 / count);
    const double apart = value - mean;
    mean += share * apart;
    variance = (1.0 - share) * (variance + share * apart * apart);
  }
};

}  // namespace dcloc
