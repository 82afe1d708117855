#include "core/odometry/late_signal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dcloc {
namespace {

constexpr LateSignalNoise kSwingingNoise{.unknown_sigma = 15.0,
                                         .change_sigma = 1.5,
                                         .change_walk = 2.5,
                                         .offset_sigma = 0.3,
                                         .offset_walk = 0.03};

double SwingingSpeed(double t_s) { return 11.0 + 3.0 * std::sin(0.8 * t_s); }

// Root mean square of the error over a minute, behind a first stretch of five seconds.
double ErrorOf(double delay_s, bool with_prompt, double assumed_delay_s) {
  LateSignal signal(kSwingingNoise);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 800; ++i) {
    const double t_s = 0.075 * i;
    if (i > 0) signal.Advance(0.075);
    signal.OnLate({SwingingSpeed(t_s - delay_s) + 0.02 * normal(random), 0.01}, assumed_delay_s);
    const double prompt_mps = SwingingSpeed(t_s) + 0.4 + 0.06 * normal(random);
    if (with_prompt) signal.OnPrompt({prompt_mps, 0.0036});
    if (t_s < 5.0) continue;
    sum += std::pow(signal.now().value - SwingingSpeed(t_s), 2);
    ++count;
  }
  return std::sqrt(sum / count);
}

TEST(LateSignalTest, BringsASignalToThePresent) {
  const double as_it_is = ErrorOf(0.3, true, 0.0);
  EXPECT_GT(as_it_is, 0.1) << "what is late is taken for now";
  EXPECT_LT(ErrorOf(0.3, true, 0.3), 0.4 * as_it_is);
  EXPECT_LT(ErrorOf(0.3, true, 0.3), 0.09);
  EXPECT_LT(ErrorOf(0.3, true, 0.3), ErrorOf(0.3, false, 0.3)) << "Doppler says how it went on";
}

TEST(LateSignalTest, ASourceThatIsAheadIsBroughtBack) {
  EXPECT_LT(ErrorOf(-0.1, true, -0.1), 0.5 * ErrorOf(-0.1, true, 0.0));
}

TEST(LateSignalTest, ThePromptSourcesOffsetIsNotTheSignals) {
  LateSignal signal(kSwingingNoise);
  for (int i = 0; i < 400; ++i) {
    signal.Advance(0.075);
    signal.OnLate({10.0, 0.01}, 0.2);
    signal.OnPrompt({10.5, 0.0036});
  }
  EXPECT_NEAR(signal.now().value, 10.0, 0.05);
}

TEST(LateSignalTest, ItIsLessCertainTheLaterItIs) {
  const auto variance = [](double delay_s) {
    LateSignal signal(kSwingingNoise);
    for (int i = 0; i < 100; ++i) {
      signal.Advance(0.075);
      signal.OnLate({10.0, 0.01}, delay_s);
    }
    return signal.now().variance;
  };
  EXPECT_GT(variance(0.1), variance(0.0));
  EXPECT_GT(variance(0.3), 2.0 * variance(0.1));
}

}  // namespace
}  // namespace dcloc
