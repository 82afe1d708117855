#pragma once

#include "absl/status/status.h"

namespace dcloc {

/// Sums over pairs of registrations, of which old ones fade: of squared errors, and of what the two
/// covariances expect of them.
struct NoisePairs {
  double error = 0.0;
  double registrations = 0.0;
  double odometry = 0.0;
  double count = 0.0;
  double prior_count = 0.0;  ///< remaining weight of the prior ratios
  double number = 0.0;       ///< of all pairs, which does not fade
};

/// What was learned of a part of the noise: of translation, or of rotation.
struct NoisePart {
  NoisePairs near;
  NoisePairs far;
  /// Of the actual variance to the modelled one.
  double odometry_ratio = 1.0;
  double registration_ratio = 1.0;
};

/// What NoiseScaleEstimator has learned. A later localizer of the same vehicle may begin with it.
struct NoiseKnowledge {
  NoisePart translation;
  NoisePart rotation;
};

/// OK, or InvalidArgument that names the number, its value and the bound.
absl::Status Validate(const NoiseKnowledge& knowledge);

}  // namespace dcloc
