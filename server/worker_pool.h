#pragma once

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

/// A fixed number of threads that run tasks, oldest first. Tasks do not throw.
class WorkerPool {
 public:
  /// `thread_count` >= 1.
  explicit WorkerPool(int thread_count);

  /// Runs what is still queued, then joins. No strand of this pool may be posted to any more.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  void Post(Task task);
  int thread_count() const { return static_cast<int>(threads_.size()); }
  /// Tasks that wait for a thread.
  std::size_t queued_count() const;

 private:
  void Run();

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Task> tasks_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

/// Tasks that run on a pool one at a time and in the order in which they were posted. Between two
/// tasks of one strand the pool's other strands get their turn, so none can starve another.
class Strand {
 public:
  /// `pool` outlives the strand's last task; the strand itself may go earlier.
  explicit Strand(WorkerPool& pool);

  void Post(Task task);

 private:
  struct Queue;
  std::shared_ptr<Queue> queue_;
};

}  // namespace dcloc::server
