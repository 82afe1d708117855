#pragma once

namespace dcloc {

/// A number and its variance.
struct ScalarEstimate {
  double value = 0.0;
  double variance = 0.0;
};

}  // namespace dcloc
