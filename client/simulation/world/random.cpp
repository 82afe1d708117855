#include "client/simulation/world/random.h"

namespace dcloc::simulation {

std::uint64_t MixBits(std::uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27U)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31U);
}

Random MakeRandom(std::uint64_t seed, Stream stream, std::initializer_list<std::uint64_t> indices) {
  std::uint64_t state = MixBits(MixBits(seed) + static_cast<std::uint64_t>(stream));
  for (const std::uint64_t index : indices) state = MixBits(state + index);
  return Random(state);
}

double Uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

double Normal(Random& random, double mean, double sigma) {
  return std::normal_distribution<double>(mean, sigma)(random);
}

bool Chance(Random& random, double probability) { return Uniform(random, 0.0, 1.0) < probability; }

int Poisson(Random& random, double mean) {
  return mean > 0.0 ? std::poisson_distribution<int>(mean)(random) : 0;
}

}  // namespace dcloc::simulation
