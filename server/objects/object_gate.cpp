#include "server/objects/object_gate.h"

#include "server/base/status.h"
#include "server/objects/object_error.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

absl::StatusOr<ObjectGate::Pass> ObjectGate::Enter() {
  const std::lock_guard lock(mutex_);
  if (!away_) return Pass::kFree;
  if (someone_looks_ || Clock::now() < next_look_) return ObjectStoreError("away a moment ago");
  someone_looks_ = true;
  return Pass::kLook;
}

void ObjectGate::Note(const absl::Status& outcome) {
  const std::lock_guard lock(mutex_);
  someone_looks_ = false;
  if (outcome.ok()) {
    if (away_.exchange(false)) spdlog::info("object store back");
    return;
  }
  next_look_ = Clock::now() + interval_;
  if (away_.exchange(true)) return;
  spdlog::error("object store away reason={}", Quoted(ObjectStoreReason(outcome)));
}

}  // namespace dcloc::server
