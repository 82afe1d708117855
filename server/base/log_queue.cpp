#include "server/base/log_queue.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "spdlog/details/log_msg_buffer.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::seconds kPatience(1);

/// What the thread works on; it lives for as long as either of the two does.
class Lines {
 public:
  Lines(std::shared_ptr<spdlog::sinks::sink> sink, std::size_t max_count)
      : sink_(std::move(sink)), max_count_(max_count) {}

  void Push(const spdlog::details::log_msg& line) {
    {
      const std::lock_guard lock(mutex_);
      if (lines_.size() == max_count_) {
        lines_.pop_front();
        ++left_out_count_;
      }
      lines_.emplace_back(line);
    }
    changed_.notify_all();
  }

  /// Gives whether all was handed on in time.
  bool WaitUntilEmpty() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [this] { return lines_.empty() && !writing_; });
  }

  void Stop() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
  }

  /// The thread's.
  void Run() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopping_ || !lines_.empty(); });
      if (lines_.empty()) return;
      const spdlog::details::log_msg_buffer line = std::move(lines_.front());
      lines_.pop_front();
      const std::size_t left_out_count = std::exchange(left_out_count_, 0);
      writing_ = true;
      lock.unlock();
      Write(line, left_out_count);
      lock.lock();
      writing_ = false;
      if (lines_.empty()) changed_.notify_all();
    }
  }

  spdlog::sinks::sink& sink() { return *sink_; }

 private:
  void Write(const spdlog::details::log_msg& line, std::size_t left_out_count) {
    if (left_out_count > 0) {
      const std::string text = absl::StrCat("lines left out count=", left_out_count);
      sink_->log(spdlog::details::log_msg(line.logger_name, spdlog::level::warn, text));
    }
    sink_->log(line);
    sink_->flush();
  }

  const std::shared_ptr<spdlog::sinks::sink> sink_;
  const std::size_t max_count_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<spdlog::details::log_msg_buffer> lines_;
  std::size_t left_out_count_ = 0;
  bool writing_ = false;
  bool stopping_ = false;
};

class Queued final : public spdlog::sinks::sink {
 public:
  Queued(std::shared_ptr<spdlog::sinks::sink> target, std::size_t max_line_count)
      : lines_(std::make_shared<Lines>(std::move(target), max_line_count)),
        thread_([lines = lines_] { lines->Run(); }) {}
  Queued(const Queued&) = delete;
  Queued& operator=(const Queued&) = delete;

  ~Queued() override {
    const bool is_empty = lines_->WaitUntilEmpty();
    lines_->Stop();
    if (is_empty) {
      thread_.join();
    } else {
      thread_.detach();
    }
  }

  void log(const spdlog::details::log_msg& line) override { lines_->Push(line); }
  void flush() override { lines_->WaitUntilEmpty(); }
  void set_pattern(const std::string& pattern) override { lines_->sink().set_pattern(pattern); }
  void set_formatter(std::unique_ptr<spdlog::formatter> formatter) override {
    lines_->sink().set_formatter(std::move(formatter));
  }

 private:
  const std::shared_ptr<Lines> lines_;
  std::thread thread_;
};

}  // namespace

std::shared_ptr<spdlog::sinks::sink> QueuedSink(std::shared_ptr<spdlog::sinks::sink> sink,
                                                std::size_t max_line_count) {
  return std::make_shared<Queued>(std::move(sink), max_line_count);
}

}  // namespace dcloc::server
