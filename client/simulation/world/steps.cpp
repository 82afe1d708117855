#include "client/simulation/world/steps.h"

#include <cstddef>

namespace dcloc::simulation {

std::vector<double> Steps(double begin, double end, double step) {
  std::vector<double> values;
  double value = begin;
  while (value < end) {
    values.push_back(value);
    value = begin + static_cast<double>(values.size()) * step;
  }
  return values;
}

std::vector<double> RandomSteps(Random& random, double begin, double end, double min_step,
                                double max_step) {
  std::vector<double> values;
  double value = begin;
  while (value < end) {
    values.push_back(value);
    value += Uniform(random, min_step, max_step);
  }
  return values;
}

}  // namespace dcloc::simulation
