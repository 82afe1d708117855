#include "client/simulation/radar/noise.h"

#include <cmath>
#include <numbers>

namespace dcloc::simulation {
namespace {
constexpr double kStudentDegreesOfFreedom = 100.0;
}  // namespace

double Noise::Draw(Random& random) const {
  switch (kind) {
    case NoiseKind::kGaussian:
      return scale * std::normal_distribution<double>()(random);
    case NoiseKind::kGamma:
      return scale * (std::gamma_distribution<double>(1.0, 1.0)(random) - 1.0);
    case NoiseKind::kStudent:
      return scale * std::student_t_distribution<double>(kStudentDegreesOfFreedom)(random);
    case NoiseKind::kRayleigh:
      return scale * std::sqrt(-2.0 * std::log1p(-Uniform(random, 0.0, 1.0)));
  }
  return 0.0;
}

double Noise::Mean() const {
  return kind == NoiseKind::kRayleigh ? scale * std::sqrt(0.5 * std::numbers::pi) : 0.0;
}

double Noise::StandardDeviation() const {
  switch (kind) {
    case NoiseKind::kGaussian:
    case NoiseKind::kGamma:
      return scale;
    case NoiseKind::kStudent:
      return scale * std::sqrt(kStudentDegreesOfFreedom / (kStudentDegreesOfFreedom - 2.0));
    case NoiseKind::kRayleigh:
      return scale * std::sqrt(2.0 - 0.5 * std::numbers::pi);
  }
  return 0.0;
}

}  // namespace dcloc::simulation
