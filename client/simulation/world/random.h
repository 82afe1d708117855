#pragma once

#include <cstdint>
#include <initializer_list>
#include <random>

namespace dcloc::simulation {

using Random = std::mt19937_64;

/// What a random stream is for. Each purpose has its own, so that drawing more for one thing leaves
/// every other thing as it was.
enum class Stream : std::uint64_t {
  kRoute = 1,
  kBuildings,
  kFurniture,
  kParking,
  kParkingChange,
  kSpeed,
  kLane,
  kTraffic,
  kSignals,
  kClock,
  kScan,
  kFixes,
  kAgeing,
  kVehicle,
};

/// A generator that depends on all of its arguments and on nothing else.
Random MakeRandom(std::uint64_t seed, Stream stream,
                  std::initializer_list<std::uint64_t> indices = {});

/// Bits of `value` well mixed (SplitMix64's finaliser): a hash, not a generator.
std::uint64_t MixBits(std::uint64_t value);

double Uniform(Random& random, double low, double high);
double Normal(Random& random, double mean, double sigma);
bool Chance(Random& random, double probability);

/// Poisson draw; 0 for a mean of 0.
int Poisson(Random& random, double mean);

}  // namespace dcloc::simulation
