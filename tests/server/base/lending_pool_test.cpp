#include "server/base/lending_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace dcloc::server {
namespace {

TEST(LendingPoolTest, WhatCameBackLastIsLentFirst) {
  LendingPool<int> pool;
  const int* first = nullptr;
  {
    const LendingPool<int>::Loan a = pool.Lend();
    const LendingPool<int>::Loan b = pool.Lend();
    EXPECT_NE(&*a, &*b);
    first = &*a;
    EXPECT_EQ(pool.idle_count(), 0U);
  }
  EXPECT_EQ(pool.idle_count(), 2U);
  EXPECT_EQ(&*pool.Lend(), first) << "a went after b";
}

TEST(LendingPoolTest, AMovedLoanIsGivenBackOnce) {
  LendingPool<int> pool;
  {
    LendingPool<int>::Loan loan = pool.Lend();
    *loan = 7;
    const LendingPool<int>::Loan moved = std::move(loan);
    EXPECT_EQ(*moved, 7);
  }
  EXPECT_EQ(pool.idle_count(), 1U);
}

TEST(LendingPoolTest, ThreadsNeverShareAnObject) {
  LendingPool<std::atomic<int>> pool;
  std::atomic<int> shared_count = 0;
  constexpr int kThreads = 4;
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&] {
      for (int round = 0; round < 2000; ++round) {
        const auto loan = pool.Lend();
        if ((*loan).fetch_add(1) != 0) ++shared_count;
        (*loan).fetch_sub(1);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(shared_count, 0);
  EXPECT_LE(pool.idle_count(), 4U);
}

}  // namespace
}  // namespace dcloc::server
