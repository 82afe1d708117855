#include "server/base/single_flight.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "server/base/keyed_mutex.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::milliseconds kWhile(50);

TEST(SingleFlightTest, ThoseWhoAskAtOnceShareOneResult) {
  SingleFlight<int> work;
  std::atomic<int> done_count = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&] {
      const absl::StatusOr<int> result = work.Do("a", [&]() -> absl::StatusOr<int> {
        std::this_thread::sleep_for(kWhile);
        return ++done_count;
      });
      EXPECT_EQ(*result, 1);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(*work.Do("a", [&]() -> absl::StatusOr<int> { return ++done_count; }), 2)
      << "who comes later does it again";
}

TEST(SingleFlightTest, ErrorsAreSharedAndKeysAreNot) {
  SingleFlight<int> work;
  const absl::StatusOr<int> outer = work.Do("a", [&]() -> absl::StatusOr<int> {
    EXPECT_EQ(*work.Do("b", []() -> absl::StatusOr<int> { return 1; }), 1);
    return absl::NotFoundError("none");
  });
  EXPECT_TRUE(absl::IsNotFound(outer.status()));
}

TEST(KeyedMutexTest, OneAtATimeHasAKey) {
  KeyedMutex mutexes;
  std::atomic<int> inside = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      const KeyedMutex::Lock lock = mutexes.Take("a");
      EXPECT_EQ(++inside, 1);
      std::this_thread::sleep_for(kWhile / 10);
      --inside;
    });
  }
  const KeyedMutex::Lock other = mutexes.Take("b");
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace dcloc::server
