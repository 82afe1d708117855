#include "server/base/worker_pool.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <latch>
#include <memory>
#include <new>
#include <optional>
#include <semaphore>
#include <string>
#include <thread>
#include <vector>

#include "server/base/within_memory.h"

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

/// A pool of one thread, and the names of the tasks that it has run, in order.
class FairnessTest : public ::testing::Test {
 protected:
  static constexpr std::chrono::milliseconds kLittle{1};
  static constexpr std::chrono::milliseconds kMuch{50};

  Task TaskOf(char name, std::chrono::milliseconds duration) {
    return [this, name, duration] {
      std::this_thread::sleep_for(duration);
      order_ += name;
    };
  }

  void PostTo(Strand& strand, int count, char name, std::chrono::milliseconds duration) {
    for (int i = 0; i < count; ++i) strand.Post(TaskOf(name, duration));
  }

  /// A task that holds the thread, so that what is posted meanwhile waits, until `Go`.
  void PostHold(Strand& strand) {
    strand.Post([this] {
      begun_.release();
      go_.acquire();
    });
  }
  void AwaitHold() { begun_.acquire(); }
  void Go() { go_.release(); }

  /// What was run when all that is posted has been.
  std::string Order() {
    pool_.reset();
    return order_;
  }

  std::string order_;
  std::binary_semaphore begun_{0};
  std::binary_semaphore go_{0};
  std::optional<WorkerPool> pool_{std::in_place, 1};
  std::optional<Strand> holder_{std::in_place, *pool_};
  std::optional<Strand> later_holder_{std::in_place, *pool_};
};

TEST_F(FairnessTest, WhoAsksForLittleIsNotHeldUpByManyWhoAskForMuch) {
  std::vector<std::unique_ptr<Strand>> busy;
  PostHold(*holder_);
  AwaitHold();
  for (int i = 0; i < 4; ++i) {
    busy.push_back(std::make_unique<Strand>(*pool_));
    PostTo(*busy.back(), 2, 'b', kMuch);
  }
  PostHold(*later_holder_);
  Go();
  AwaitHold();
  Strand quiet(*pool_);
  PostTo(quiet, 1, 'q', kLittle);
  Go();
  EXPECT_EQ(Order(), "bbbbqbbbb");
}

TEST_F(FairnessTest, WhoAsksForLessAtATimeIsServedMoreOften) {
  Strand much(*pool_);
  Strand little(*pool_);
  PostHold(*holder_);
  AwaitHold();
  PostTo(much, 2, 'm', kMuch);
  PostTo(little, 6, 'l', kLittle);
  Go();
  EXPECT_EQ(Order(), "mllllllm");
}

TEST_F(FairnessTest, APauseGivesNoCredit) {
  Strand working(*pool_);
  Strand paused(*pool_);
  PostTo(working, 6, 'w', kMuch);
  PostHold(working);
  AwaitHold();
  PostTo(paused, 6, 'p', kMuch);
  PostTo(working, 1, 'w', kMuch);
  Go();
  const std::string order = Order();
  EXPECT_EQ(order.substr(0, 7), "wwwwwwp");
  EXPECT_EQ(order.back(), 'p') << order << ": not all of them before the other's next";
}

TEST_F(FairnessTest, TasksOutsideOfStrandsShareATurn) {
  Strand strand(*pool_);
  PostHold(*holder_);
  AwaitHold();
  for (int i = 0; i < 3; ++i) pool_->Post(TaskOf('o', kMuch));
  PostHold(*later_holder_);
  Go();
  AwaitHold();
  pool_->Post(TaskOf('o', kLittle));
  PostTo(strand, 1, 's', kLittle);
  Go();
  EXPECT_EQ(Order(), "oooso");
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

TEST(LaneTest, ALengthyTaskHoldsUpNoQuickOne) {
  std::latch quick_done(1);
  WorkerPool pool(1, 1);
  // Ends only when the quick task, posted after it, has been run.
  pool.Post([&] { quick_done.wait(); }, Lane::kLengthy);
  pool.Post([&] { quick_done.count_down(); });
  quick_done.wait();
}

TEST(LaneTest, WithoutThreadsOfTheirOwnLengthyTasksAreRunWithTheRest) {
  std::vector<int> order;
  {
    std::latch begun(1);
    WorkerPool pool(1);
    pool.Post([&] { begun.wait(); });
    pool.Post([&] { order.push_back(0); }, Lane::kLengthy);
    pool.Post([&] { order.push_back(1); });
    EXPECT_EQ(pool.queued_count(Lane::kLengthy), 0U);
    begun.count_down();
  }
  EXPECT_EQ(order, std::vector<int>({0, 1}));
}

TEST(LaneTest, LengthyThreadsComeAfterTheOthersForTheSystem) {
  if (getpriority(PRIO_PROCESS, 0) == 19) GTEST_SKIP() << "the process is the last already";
  int quick_nice = 0;
  int lengthy_nice = 0;
  {
    WorkerPool pool(1, 1);
    pool.Post([&] { quick_nice = getpriority(PRIO_PROCESS, 0); });
    pool.Post([&] { lengthy_nice = getpriority(PRIO_PROCESS, 0); }, Lane::kLengthy);
  }
  EXPECT_EQ(quick_nice, getpriority(PRIO_PROCESS, 0));
  EXPECT_GT(lengthy_nice, quick_nice);
}

TEST(LaneTest, AStrandKeepsItsOrderAcrossLanesAndThePoolEndsAfterIt) {
  constexpr int kTasks = 300;
  std::vector<int> order;
  {
    std::latch done(1);
    WorkerPool pool(2, 2);
    Strand strand(pool);
    for (int task = 0; task < kTasks; ++task) {
      strand.Post([&, task] {
        order.push_back(task);
        strand.SetLane(task % 3 == 0 ? Lane::kLengthy : Lane::kQuick);
      });
    }
    // The strand outlives its tasks: SetLane is called on it.
    strand.Post([&] { done.count_down(); });
    done.wait();
  }
  ASSERT_EQ(order.size(), kTasks);
  for (int task = 0; task < kTasks; ++task) ASSERT_EQ(order[task], task);
}

TEST(LaneTest, WhileOneStrandIsLengthyAnotherIsServed) {
  std::latch served(100);
  WorkerPool pool(1, 1);
  Strand lengthy(pool);
  Strand other(pool);
  lengthy.SetLane(Lane::kLengthy);
  lengthy.Post([&] { served.wait(); });
  for (int i = 0; i < 100; ++i) other.Post([&] { served.count_down(); });
  served.wait();
}

TEST(OutOfMemoryTest, ATaskThatGetsNoneEndsAndTheNextOnesRun) {
  std::latch done(2);
  std::shared_ptr<int> held = std::make_shared<int>(0);
  const std::weak_ptr<int> is_held = held;
  WorkerPool pool(1);
  Strand strand(pool);
  pool.Post([held = std::move(held)] { throw std::bad_alloc(); });
  strand.Post([] { throw std::bad_alloc(); });
  strand.Post([&] { done.count_down(); });
  pool.Post([&] { done.count_down(); });
  done.wait();
  EXPECT_TRUE(is_held.expired()) << "what it held is let go of";
}

TEST(OutOfMemoryTest, ItsStatusFitsIntoAStringWithoutMemory) {
  const absl::Status status = WithinMemory([] { throw std::bad_alloc(); });
  EXPECT_TRUE(absl::IsResourceExhausted(status));
  EXPECT_LE(status.message().size(), std::string().capacity());
  EXPECT_TRUE(WithinMemory([] {}).ok());
  EXPECT_TRUE(absl::IsNotFound(WithinMemory([] { return absl::NotFoundError("x"); })));
}

}  // namespace
}  // namespace dcloc::server
