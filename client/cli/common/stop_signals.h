#pragma once

#include <signal.h>

#include <functional>
#include <thread>

namespace dcloc::cli {

/// While this lives, SIGINT and SIGTERM do not end the process. Make it before the threads that are
/// to be spared: they inherit the signal mask.
class StopSignals {
 public:
  StopSignals();
  /// Signals that came and were not watched for take effect now.
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// While the thread given back lives, each such signal calls `on_signal` on it, with 1 for the
  /// first one, 2 for the second.
  [[nodiscard]] std::jthread Watch(std::function<void(int)> on_signal) const;

 private:
  sigset_t signals_;
  sigset_t previous_;
};

}  // namespace dcloc::cli
