#pragma once

#include <vector>

#include "client/simulation/world/random.h"

namespace dcloc::simulation {

/// begin, begin + step, ... below `end`; `step` > 0.
std::vector<double> Steps(double begin, double end, double step);

/// begin and on by steps drawn evenly from [min_step, max_step], below `end`; `min_step` > 0.
std::vector<double> RandomSteps(Random& random, double begin, double end, double min_step,
                                double max_step);

}  // namespace dcloc::simulation
