#pragma once

#include <atomic>
#include <functional>

#include "absl/status/status.h"

namespace dcloc::server {

/// Whether the server still answers, by probing it. `Check` is for one thread, `ok` for any.
class Liveness {
 public:
  /// `probe` tests the server; `report` is called when the result changes.
  Liveness(std::function<absl::Status()> probe, std::function<void(bool ok)> report);

  /// Probes once. Only two failures in a row count as not answering. Each success is reported to
  /// the service manager, whose watchdog restarts a server without successes.
  void Check();

  bool ok() const { return ok_; }

 private:
  const std::function<absl::Status()> probe_;
  const std::function<void(bool)> report_;
  std::atomic<bool> ok_ = true;
  int failure_count_ = 0;
};

}  // namespace dcloc::server
