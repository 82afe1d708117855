#pragma once

#include "core/posegraph/state_chain.h"

namespace dcloc {

/// Finds the poses of a chain by Ceres (Levenberg-Marquardt), from wherever they are, until the
/// cost falls by less than `tolerance` of itself. False, and the poses stay as they were, when it
/// finds none.
template <int Dim>
bool SolveByCeres(StateChain<Dim>& chain, double tolerance = 1e-6);

}  // namespace dcloc
