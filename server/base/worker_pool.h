#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
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

/// A fixed number of threads that run tasks. Whoever has had less of a lane goes first: a strand,
/// or all tasks together that are posted outside of strands; else the oldest one. This is
/// start-time fair queueing (Goyal, Vin, Cheng, SIGCOMM 1996): who asks for little is not held up
/// by those who ask for much, and nobody starves. A task that gets no memory (std::bad_alloc) ends
/// there; what it holds is let go of. Tasks throw nothing else.
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
  friend class Strand;

  using Clock = std::chrono::steady_clock;

  // How long somebody has had threads of a line. Who comes back after a pause is not owed for it:
  // it begins where those are that were served meanwhile.
  using Served = std::chrono::nanoseconds;

  struct Waiting {
    Served had{};
    std::uint64_t number = 0;  // of those with as much, the oldest one goes first
    Task task;

    bool operator>(const Waiting& other) const {
      return had != other.had ? had > other.had : number > other.number;
    }
  };

  // A lane's tasks and threads.
  struct Line {
    std::condition_variable wake;
    std::vector<Waiting> tasks;  // a heap, the next one in front
    std::vector<std::thread> threads;
    std::uint64_t posted_count = 0;
    Served newest{};  // what the one had had that was served last
    Served others{};  // what tasks outside of strands have had
  };

  // `had` is what whoever posts has had of the lane; it moves on over a pause.
  void Enqueue(Task task, Lane lane, Served& had);
  Line& LineOf(Lane lane);
  void Run(Line& line);
  void WakeAll();

  mutable std::mutex mutex_;
  std::array<Line, 2> lines_;         // by lane
  std::size_t unfinished_count_ = 0;  // queued or running: these may still post to either lane
  bool stopping_ = false;
};

/// Tasks that run on a pool one at a time and in the order in which they were posted. Between two
/// tasks of one strand the pool's other strands get their turn, those first that have had less.
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
