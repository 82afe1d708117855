#pragma once

#include <atomic>
#include <functional>

#include "absl/status/status.h"

namespace dcloc::server {

/// Whether the server still does what it is there for, by trying it out. `Check` is for one thread,
/// `ok` for any.
class Liveness {
 public:
  /// `probe` tries; `report` is told when it turns out otherwise than before.
  Liveness(std::function<absl::Status()> probe, std::function<void(bool ok)> report);

  /// Tries once. One failure may be an accident, two in a row are not. Each success is told to the
  /// service manager, whose watchdog ends a server that has none for too long.
  void Check();

  bool ok() const { return ok_; }

 private:
  const std::function<absl::Status()> probe_;
  const std::function<void(bool)> report_;
  std::atomic<bool> ok_ = true;
  int failure_count_ = 0;
};

}  // namespace dcloc::server
