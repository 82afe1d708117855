#include "server/base/worker_pool.h"

#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <utility>

#include "server/base/within_memory.h"

namespace dcloc::server {
namespace {

std::size_t NumberOf(Lane lane) { return lane == Lane::kQuick ? 0 : 1; }

/// Whatever that of the thread is that makes the pool.
void ScheduleAsUsual() {
  const sched_param no_priority{};
  sched_setscheduler(0, SCHED_OTHER, &no_priority);
}

/// On Linux a thread's own; a process may always take itself back.
void TakeThreadBack() {
  constexpr int kNicer = 10;  // about a tenth of the processor where all others want it
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kNicer);
}

void RunAndLetGo(Task& task) {
  WithinMemory(task).IgnoreError();
  task = nullptr;  // what it holds may be large, and is not to be freed under a lock
}

}  // namespace

WorkerPool::WorkerPool(int thread_count, int lengthy_thread_count) {
  Line& quick = lines_[NumberOf(Lane::kQuick)];
  Line& lengthy = lines_[NumberOf(Lane::kLengthy)];
  quick.threads.reserve(static_cast<std::size_t>(thread_count));
  for (int i = 0; i < thread_count; ++i) {
    quick.threads.emplace_back([this, &quick] {
      ScheduleAsUsual();
      Run(quick);
    });
  }
  lengthy.threads.reserve(static_cast<std::size_t>(lengthy_thread_count));
  for (int i = 0; i < lengthy_thread_count; ++i) {
    lengthy.threads.emplace_back([this, &lengthy] {
      ScheduleAsUsual();
      TakeThreadBack();
      Run(lengthy);
    });
  }
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  WakeAll();
  for (Line& line : lines_) {
    for (std::thread& thread : line.threads) thread.join();
  }
}

void WorkerPool::WakeAll() {
  for (Line& line : lines_) line.wake.notify_all();
}

WorkerPool::Line& WorkerPool::LineOf(Lane lane) {
  Line& line = lines_[NumberOf(lane)];
  return line.threads.empty() ? lines_[NumberOf(Lane::kQuick)] : line;
}

void WorkerPool::Post(Task task, Lane lane) {
  Line& line = LineOf(lane);
  auto counted = [this, &line, task = std::move(task)]() mutable {
    const Clock::time_point begin = Clock::now();
    RunAndLetGo(task);
    const Served cost = Clock::now() - begin;
    const std::lock_guard lock(mutex_);
    line.others += cost;
  };
  Enqueue(std::move(counted), lane, line.others);
}

void WorkerPool::Enqueue(Task task, Lane lane, Served& had) {
  Line& line = LineOf(lane);
  {
    const std::lock_guard lock(mutex_);
    had = std::max(had, line.newest);
    line.tasks.push_back({had, line.posted_count++, std::move(task)});
    std::ranges::push_heap(line.tasks, std::greater<>());
    ++unfinished_count_;
  }
  line.wake.notify_one();
}

std::size_t WorkerPool::queued_count(Lane lane) const {
  const std::lock_guard lock(mutex_);
  return lines_[NumberOf(lane)].tasks.size();
}

void WorkerPool::Run(Line& line) {
  std::unique_lock lock(mutex_);
  while (true) {
    line.wake.wait(lock, [this, &line] {
      return !line.tasks.empty() || (stopping_ && unfinished_count_ == 0);
    });
    if (line.tasks.empty()) return;
    std::ranges::pop_heap(line.tasks, std::greater<>());
    line.newest = std::max(line.newest, line.tasks.back().had);
    Task task = std::move(line.tasks.back().task);
    line.tasks.pop_back();
    lock.unlock();
    RunAndLetGo(task);
    lock.lock();
    --unfinished_count_;
    if (stopping_ && unfinished_count_ == 0) WakeAll();
  }
}

struct Strand::Queue : std::enable_shared_from_this<Queue> {
  explicit Queue(WorkerPool& worker_pool) : pool(worker_pool) {}

  void Post(Task task) {
    std::unique_lock lock(mutex);
    tasks.push_back(std::move(task));
    if (scheduled) return;
    try {
      TakeATurn();
      scheduled = true;
    } catch (const std::bad_alloc&) {
      const Task gone = std::move(tasks.back());
      tasks.pop_back();
      lock.unlock();  // letting go of it may post again
      throw;
    }
  }

  void SetLane(Lane of_the_next) {
    const std::lock_guard lock(mutex);
    lane = of_the_next;
  }

  void TakeATurn() {
    pool.Enqueue([self = shared_from_this(), lane = lane] { self->RunOne(lane); }, lane,
                 had[NumberOf(lane)]);
  }

  void RunOne(Lane of_this_turn) {
    std::unique_lock lock(mutex);
    do {
      Task task = std::move(tasks.front());
      tasks.pop_front();
      lock.unlock();
      const WorkerPool::Clock::time_point begin = WorkerPool::Clock::now();
      RunAndLetGo(task);
      const WorkerPool::Served cost = WorkerPool::Clock::now() - begin;
      lock.lock();
      had[NumberOf(of_this_turn)] += cost;
      scheduled = !tasks.empty();
      // Without memory for its turn in the pool the next one runs here.
    } while (scheduled && !WithinMemory([this] { TakeATurn(); }).ok());
  }

  WorkerPool& pool;
  std::mutex mutex;
  std::deque<Task> tasks;
  Lane lane = Lane::kQuick;
  std::array<WorkerPool::Served, 2> had{};  ///< of each lane
  bool scheduled = false;                   ///< RunOne is on the pool; at most one at a time
};

Strand::Strand(WorkerPool& pool) : queue_(std::make_shared<Queue>(pool)) {}

void Strand::Post(Task task) { queue_->Post(std::move(task)); }

void Strand::SetLane(Lane lane) { queue_->SetLane(lane); }

}  // namespace dcloc::server
