#include "server/base/peer_wait.h"

#include <utility>

namespace dcloc::server {

void PeerBoundCalls::Add(std::weak_ptr<PeerBoundCall> call) {
  const std::lock_guard lock(mutex_);
  calls_.push_back(std::move(call));
}

void PeerBoundCalls::Check(PeerWait::Clock::time_point now) {
  // Without the lock: the last reference to a call may go here.
  for (const std::shared_ptr<PeerBoundCall>& call : Living()) call->CheckPeer(now);
}

std::vector<std::shared_ptr<PeerBoundCall>> PeerBoundCalls::Living() {
  std::vector<std::shared_ptr<PeerBoundCall>> living;
  const std::lock_guard lock(mutex_);
  std::erase_if(calls_, [&living](const std::weak_ptr<PeerBoundCall>& call) {
    std::shared_ptr<PeerBoundCall> held = call.lock();
    if (held == nullptr) return true;
    living.push_back(std::move(held));
    return false;
  });
  return living;
}

}  // namespace dcloc::server
