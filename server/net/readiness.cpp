#include "server/net/readiness.h"

#include <utility>

namespace dcloc::server {

Readiness::Readiness(std::function<absl::Status()> probe)
    : probe_(std::move(probe)), status_(absl::UnavailableError("the server starts")) {}

void Readiness::Check() {
  absl::Status status = probe_();
  const std::lock_guard lock(mutex_);
  status_ = std::move(status);
}

absl::Status Readiness::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

}  // namespace dcloc::server
