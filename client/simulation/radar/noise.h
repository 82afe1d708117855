#pragma once

#include "client/simulation/world/random.h"

namespace dcloc::simulation {

/// Shapes of measurement noise, after Table IV of the DC-Loc++ paper.
enum class NoiseKind { kGaussian, kGamma, kStudent, kRayleigh };

/// Noise of one measured quantity: `scale` as printed in Table IV.
///
/// Our reading of the table:
/// - Gaussian N(0, scale^2).
/// - Gamma "Gamma(0, scale)": a Gamma law has no shape 0, so the 0 is read as the mean and `scale`
///   as the scale, with shape 1, the one shape whose standard deviation is `scale` too:
///   scale * (Gamma(1, 1) - 1). Skewed, with a zero mean.
/// - Student: scale * t(100), nearly Gaussian.
/// - Rayleigh(scale) as printed: never negative, mean 1.2533 scale. It biases every range, angle
///   and range rate, which no covariance models; that is what the experiment is about.
struct Noise {
  NoiseKind kind = NoiseKind::kGaussian;
  double scale = 0.0;

  double Draw(Random& random) const;
  double Mean() const;
  double StandardDeviation() const;
};

}  // namespace dcloc::simulation
