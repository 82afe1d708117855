#pragma once

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

/// Of several threads that want the same at once, the first one does the work, and all get what it
/// gives. Who comes later does it again. Thread-safe.
template <typename Value>
class SingleFlight {
 public:
  using Result = absl::StatusOr<Value>;

  /// Calls `work`, or waits for the thread that does it for the same `key`.
  Result Do(const std::string& key, absl::FunctionRef<Result()> work) {
    std::shared_ptr<Turn> turn;
    {
      std::unique_lock lock(mutex_);
      std::shared_ptr<Turn>& entry = turns_[key];
      if (entry != nullptr) {
        turn = entry;
        done_.wait(lock, [&] { return turn->result.has_value(); });
        return *turn->result;
      }
      turn = entry = std::make_shared<Turn>();
    }
    Result result = OutOfMemory();
    WithinMemory([&] { result = work(); }).IgnoreError();  // the others must not wait for ever
    const std::lock_guard lock(mutex_);
    turn->result = result;
    turns_.erase(key);
    done_.notify_all();
    return result;
  }

 private:
  struct Turn {
    std::optional<Result> result;
  };

  std::mutex mutex_;
  std::condition_variable done_;
  std::map<std::string, std::shared_ptr<Turn>> turns_;  ///< under way
};

}  // namespace dcloc::server
