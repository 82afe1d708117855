#pragma once

#include <cmath>
#include <numbers>

namespace dcloc {

/// A number and its variance.
struct ScalarEstimate {
  double value = 0.0;
  double variance = 0.0;
};

/// Log-density of a normal distribution of this variance, at `difference` from its mean.
inline double LogNormal(double difference, double variance) {
  return -0.5 * (difference * difference / variance + std::log(2.0 * std::numbers::pi * variance));
}

}  // namespace dcloc
