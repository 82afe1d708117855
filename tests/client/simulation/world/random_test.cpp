#include "client/simulation/world/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace dcloc::simulation {
namespace {

TEST(RandomTest, AGeneratorDependsOnAllOfItsArgumentsAndOnNothingElse) {
  const auto first = [](std::uint64_t seed, Stream stream,
                        std::initializer_list<std::uint64_t> indices = {}) {
    return MakeRandom(seed, stream, indices)();
  };
  EXPECT_EQ(first(7, Stream::kScan, {1, 2}), first(7, Stream::kScan, {1, 2}));
  const std::set<std::uint64_t> draws = {
      first(7, Stream::kScan),         first(8, Stream::kScan),
      first(7, Stream::kClock),        first(7, Stream::kScan, {1, 2}),
      first(7, Stream::kScan, {2, 1}), first(7, Stream::kScan, {1})};
  EXPECT_EQ(draws.size(), 6U);
}

TEST(RandomTest, DrawsHaveTheirMoments) {
  Random random = MakeRandom(1, Stream::kFixes);
  constexpr int kDraws = 20'000;
  double normal_sum = 0.0;
  double normal_square_sum = 0.0;
  int chances = 0;
  int events = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double normal = Normal(random, 2.0, 0.5);
    normal_sum += normal;
    normal_square_sum += normal * normal;
    chances += Chance(random, 0.25) ? 1 : 0;
    events += Poisson(random, 1.5);
    const double uniform = Uniform(random, -3.0, -2.0);
    ASSERT_TRUE(uniform >= -3.0 && uniform < -2.0) << uniform;
  }
  // Five standard errors of each mean.
  const double mean = normal_sum / kDraws;
  EXPECT_NEAR(mean, 2.0, 5.0 * 0.5 / std::sqrt(kDraws));
  EXPECT_NEAR(std::sqrt(normal_square_sum / kDraws - mean * mean), 0.5, 0.02);
  EXPECT_NEAR(chances, 0.25 * kDraws, 5.0 * std::sqrt(0.25 * 0.75 * kDraws));
  EXPECT_NEAR(events, 1.5 * kDraws, 5.0 * std::sqrt(1.5 * kDraws));
  EXPECT_EQ(Poisson(random, 0.0), 0);
}

}  // namespace
}  // namespace dcloc::simulation
