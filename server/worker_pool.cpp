#include "server/worker_pool.h"

#include <utility>

namespace dcloc::server {

WorkerPool::WorkerPool(int thread_count) {
  threads_.reserve(static_cast<std::size_t>(thread_count));
  for (int i = 0; i < thread_count; ++i) threads_.emplace_back([this] { Run(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::Post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  wake_.notify_one();
}

std::size_t WorkerPool::queued_count() const {
  const std::lock_guard lock(mutex_);
  return tasks_.size();
}

void WorkerPool::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !tasks_.empty(); });
    if (tasks_.empty()) return;
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
    task = nullptr;  // what it holds may be large, and is not to be freed under the lock
    lock.lock();
  }
}

struct Strand::Queue : std::enable_shared_from_this<Queue> {
  explicit Queue(WorkerPool& worker_pool) : pool(worker_pool) {}

  void Post(Task task) {
    const std::lock_guard lock(mutex);
    tasks.push_back(std::move(task));
    if (!scheduled) Schedule();
  }

  void Schedule() {
    scheduled = true;
    pool.Post([self = shared_from_this()] { self->RunOne(); });
  }

  void RunOne() {
    std::unique_lock lock(mutex);
    Task task = std::move(tasks.front());
    tasks.pop_front();
    lock.unlock();
    task();
    task = nullptr;
    lock.lock();
    scheduled = false;
    if (!tasks.empty()) Schedule();
  }

  WorkerPool& pool;
  std::mutex mutex;
  std::deque<Task> tasks;
  bool scheduled = false;  ///< RunOne is on the pool; at most one at a time
};

Strand::Strand(WorkerPool& pool) : queue_(std::make_shared<Queue>(pool)) {}

void Strand::Post(Task task) { queue_->Post(std::move(task)); }

}  // namespace dcloc::server
