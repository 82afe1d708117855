#include "server/base/end_of_waiting.h"

#include <gtest/gtest.h>

#include <memory>

namespace dcloc::server {
namespace {

TEST(EndOfWaitingTest, EndsWhatLivesOnce) {
  EndOfWaiting waiting;
  const auto first = std::make_shared<int>(0);
  auto gone = std::make_shared<int>(0);
  int of_gone = 0;
  waiting.Add<int>(first, [](int& count) { ++count; });
  waiting.Add<int>(gone, [&of_gone](int&) { ++of_gone; });
  gone.reset();
  EXPECT_EQ(*first, 0);
  waiting.EndAll();
  waiting.EndAll();
  EXPECT_EQ(*first, 1);
  EXPECT_EQ(of_gone, 0);
}

TEST(EndOfWaitingTest, WhatComesAfterwardsEndsAtOnce) {
  EndOfWaiting waiting;
  waiting.EndAll();
  const auto late = std::make_shared<int>(0);
  waiting.Add<int>(late, [](int& count) { ++count; });
  EXPECT_EQ(*late, 1);
}

TEST(EndOfWaitingTest, WhatEndsMayBeTheLastToHoldIt) {
  EndOfWaiting waiting;
  auto held = std::make_shared<std::shared_ptr<int>>();
  const auto one = std::make_shared<int>(7);
  *held = one;
  waiting.Add<std::shared_ptr<int>>(held, [&held](std::shared_ptr<int>&) { held.reset(); });
  waiting.EndAll();
  EXPECT_EQ(held, nullptr);
  EXPECT_EQ(one.use_count(), 1);
}

}  // namespace
}  // namespace dcloc::server
