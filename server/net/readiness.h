#pragma once

#include <functional>
#include <mutex>

#include "absl/status/status.h"

namespace dcloc::server {

/// Whether the server answers new connections, as of its last probe: whoever asks need not wait for
/// one. `Check` is for one thread, `status` for any.
class Readiness {
 public:
  explicit Readiness(std::function<absl::Status()> probe);

  /// Probes once.
  void Check();

  /// Unavailable before the first probe.
  absl::Status status() const;

 private:
  const std::function<absl::Status()> probe_;
  mutable std::mutex mutex_;
  absl::Status status_;
};

}  // namespace dcloc::server
