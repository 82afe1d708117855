#include "server/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <memory>
#include <vector>

namespace dcloc::server {
namespace {

TEST(WorkerPoolTest, RunsAllTasksBeforeItEnds) {
  std::atomic<int> count = 0;
  {
    WorkerPool pool(3);
    for (int i = 0; i < 1000; ++i) pool.Post([&count] { ++count; });
  }
  EXPECT_EQ(count, 1000);
}

TEST(WorkerPoolTest, RunsTasksAtOnceOnItsThreads) {
  WorkerPool pool(2);
  // Each of the two tasks waits for the other: one thread alone would never get through.
  std::latch both(2);
  std::latch done(2);
  for (int i = 0; i < 2; ++i) {
    pool.Post([&] {
      both.arrive_and_wait();
      done.count_down();
    });
  }
  done.wait();
  EXPECT_EQ(pool.thread_count(), 2);
}

TEST(StrandTest, KeepsOrderAndNeverRunsTwoTasksAtOnce) {
  constexpr int kStrands = 8;
  constexpr int kTasks = 2000;
  struct State {
    explicit State(WorkerPool& pool) : strand(pool) {}
    std::vector<int> order;  // not atomic: a strand's tasks need no lock among themselves
    std::atomic<int> running = 0;
    std::atomic<int> overlaps = 0;
    Strand strand;
  };
  std::vector<std::unique_ptr<State>> states;
  {
    WorkerPool pool(4);
    for (int i = 0; i < kStrands; ++i) states.push_back(std::make_unique<State>(pool));
    for (int task = 0; task < kTasks; ++task) {
      for (const auto& state : states) {
        state->strand.Post([s = state.get(), task] {
          if (s->running.fetch_add(1) != 0) ++s->overlaps;
          s->order.push_back(task);
          s->running.fetch_sub(1);
        });
      }
    }
  }
  for (const auto& state : states) {
    EXPECT_EQ(state->overlaps, 0);
    ASSERT_EQ(state->order.size(), kTasks);
    for (int task = 0; task < kTasks; ++task) ASSERT_EQ(state->order[task], task);
  }
}

TEST(StrandTest, ABusyStrandDoesNotStarveAnother) {
  WorkerPool pool(1);
  Strand busy(pool);
  Strand other(pool);
  std::latch begun(1);
  std::latch go(1);
  std::atomic<int> busy_count = 0;
  std::atomic<int> busy_count_at_other = -1;
  busy.Post([&] {
    begun.count_down();
    go.wait();
  });
  begun.wait();
  for (int i = 0; i < 100; ++i) busy.Post([&] { ++busy_count; });
  std::latch done(1);
  other.Post([&] {
    busy_count_at_other = busy_count.load();
    done.count_down();
  });
  go.count_down();
  done.wait();
  EXPECT_LE(busy_count_at_other, 1);
}

TEST(StrandTest, ItsTasksOutliveIt) {
  std::atomic<int> count = 0;
  {
    WorkerPool pool(2);
    {
      Strand strand(pool);
      for (int i = 0; i < 100; ++i) strand.Post([&count] { ++count; });
    }
  }
  EXPECT_EQ(count, 100);
}

TEST(StrandTest, ATaskMayPostToItsOwnStrand) {
  std::atomic<int> count = 0;
  {
    WorkerPool pool(2);
    Strand strand(pool);
    std::latch done(1);
    strand.Post([&] {
      ++count;
      strand.Post([&] {
        ++count;
        done.count_down();
      });
    });
    done.wait();
  }
  EXPECT_EQ(count, 2);
}

}  // namespace
}  // namespace dcloc::server
