#include "server/base/shutdown_hooks.h"

#include <gtest/gtest.h>

#include <memory>

namespace dcloc::server {
namespace {

TEST(ShutdownHooksTest, RunsOnceForAnOwnerThatLives) {
  ShutdownHooks hooks;
  const auto first = std::make_shared<int>(0);
  auto gone = std::make_shared<int>(0);
  int of_gone = 0;
  hooks.Add<int>(first, [](int& count) { ++count; });
  hooks.Add<int>(gone, [&of_gone](int&) { ++of_gone; });
  gone.reset();
  EXPECT_EQ(*first, 0);
  hooks.RunAll();
  hooks.RunAll();
  EXPECT_EQ(*first, 1);
  EXPECT_EQ(of_gone, 0);
}

TEST(ShutdownHooksTest, WhatIsAddedAfterwardsRunsAtOnce) {
  ShutdownHooks hooks;
  hooks.RunAll();
  const auto late = std::make_shared<int>(0);
  hooks.Add<int>(late, [](int& count) { ++count; });
  EXPECT_EQ(*late, 1);
}

TEST(ShutdownHooksTest, AHookMayReleaseTheLastReference) {
  ShutdownHooks hooks;
  auto held = std::make_shared<std::shared_ptr<int>>();
  const auto one = std::make_shared<int>(7);
  *held = one;
  hooks.Add<std::shared_ptr<int>>(held, [&held](std::shared_ptr<int>&) { held.reset(); });
  hooks.RunAll();
  EXPECT_EQ(held, nullptr);
  EXPECT_EQ(one.use_count(), 1);
}

}  // namespace
}  // namespace dcloc::server
