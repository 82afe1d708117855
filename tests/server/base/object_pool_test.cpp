#include "server/base/object_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace dcloc::server {
namespace {

TEST(ObjectPoolTest, WhatCameBackLastIsLentFirst) {
  ObjectPool<int> pool;
  const int* first = nullptr;
  {
    const ObjectPool<int>::Lease a = pool.Acquire();
    const ObjectPool<int>::Lease b = pool.Acquire();
    EXPECT_NE(&*a, &*b);
    first = &*a;
    EXPECT_EQ(pool.idle_count(), 0U);
  }
  EXPECT_EQ(pool.idle_count(), 2U);
  EXPECT_EQ(&*pool.Acquire(), first) << "a went after b";
}

TEST(ObjectPoolTest, AMovedLeaseIsGivenBackOnce) {
  ObjectPool<int> pool;
  {
    ObjectPool<int>::Lease lease = pool.Acquire();
    *lease = 7;
    const ObjectPool<int>::Lease moved = std::move(lease);
    EXPECT_EQ(*moved, 7);
  }
  EXPECT_EQ(pool.idle_count(), 1U);
}

TEST(ObjectPoolTest, ThreadsNeverShareAnObject) {
  ObjectPool<std::atomic<int>> pool;
  std::atomic<int> shared_count = 0;
  constexpr int kThreads = 4;
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&] {
      for (int round = 0; round < 2000; ++round) {
        const auto lease = pool.Acquire();
        if ((*lease).fetch_add(1) != 0) ++shared_count;
        (*lease).fetch_sub(1);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(shared_count, 0);
  EXPECT_LE(pool.idle_count(), 4U);
}

}  // namespace
}  // namespace dcloc::server
