#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "absl/functional/any_invocable.h"

namespace dcloc::server {

using Task = absl::AnyInvocable<void()>;

/// How long a task takes: half a millisecond, or tens of milliseconds. Lengthy tasks must not delay
/// quick ones.
enum class Lane { kQuick, kLengthy };

/// A fixed number of threads that run tasks, in each lane oldest first. A task that gets no memory
/// (std::bad_alloc) ends there; what it holds is let go of. Tasks throw nothing else.
class WorkerPool {
 public:
  /// `thread_count` >= 1 for quick tasks. Lengthy tasks have `lengthy_thread_count` threads of
  /// their own, with a lower priority; if that is 0, they run on the threads of the quick ones.
  explicit WorkerPool(int thread_count, int lengthy_thread_count = 0);

  /// Runs the queued tasks and those that they post, then joins the threads. No other thread may
  /// post any more.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Without memory it throws std::bad_alloc, and the task is gone.
  void Post(Task task, Lane lane = Lane::kQuick);

  /// Those for quick tasks.
  int thread_count() const { return static_cast<int>(lines_[0].threads.size()); }

  /// Tasks that wait for a thread.
  std::size_t queued_count(Lane lane = Lane::kQuick) const;

 private:
  // A lane's tasks and threads.
  struct Line {
    std::condition_variable wake;
    std::deque<Task> tasks;
    std::vector<std::thread> threads;
  };

  void Run(Line& line);
  void WakeAll();

  mutable std::mutex mutex_;
  std::array<Line, 2> lines_;         // by lane
  std::size_t unfinished_count_ = 0;  // queued or running: these may still post to either lane
  bool stopping_ = false;
};

/// Tasks that run on a pool one at a time and in the order in which they were posted. Between two
/// tasks of one strand the pool's other strands get their turn, so none can starve another.
class Strand {
 public:
  /// `pool` outlives the strand's last task; the strand itself may go earlier.
  explicit Strand(WorkerPool& pool);

  /// Without memory it throws std::bad_alloc, and the task is gone.
  void Post(Task task);

  /// The lane of the tasks that have not begun yet; at first it is the quick one.
  void SetLane(Lane lane);

 private:
  struct Queue;
  std::shared_ptr<Queue> queue_;
};

}  // namespace dcloc::server
