#pragma once

#include <grpcpp/client_context.h>

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace dcloc::server {

/// A vehicle's next session may open at any replica, and the first one that does is recorded. This
/// decides which it is, and lets go of the others. Thread-safe.
class RecordElection {
 public:
  /// The place of this server's own sessions; those of others count from 0.
  static constexpr int kHere = -1;

  /// `context` is of the call to the replica of `place`; cancelled once another one is first.
  void Add(int place, std::weak_ptr<grpc::ClientContext> context) {
    const std::lock_guard lock(mutex_);
    calls_.emplace_back(place, std::move(context));
  }

  /// Something has come from `place`: whether it is of the session that is recorded.
  bool Take(int place) {
    {
      const std::lock_guard lock(mutex_);
      if (first_) return first_ == place;
      first_ = place;
    }
    CancelOthers(place);
    return true;
  }

  /// Whether the session that is recorded is at `place`.
  bool IsFirst(int place) const {
    const std::lock_guard lock(mutex_);
    return first_ == place;
  }

  bool IsDecidedAgainst(int place) const {
    const std::lock_guard lock(mutex_);
    return first_ && *first_ != place;
  }

  /// Nothing will be recorded. False where it was decided before, be it by giving up: whoever
  /// decides says to the caller why.
  bool GiveUp() {
    {
      const std::lock_guard lock(mutex_);
      if (first_) return false;
      first_ = kNowhere;
    }
    CancelOthers(kNowhere);
    return true;
  }

 private:
  static constexpr int kNowhere = -2;

  /// Without the mutex: what ends may ask at once whether it was the first.
  void CancelOthers(int place) {
    std::vector<std::pair<int, std::weak_ptr<grpc::ClientContext>>> calls;
    {
      const std::lock_guard lock(mutex_);
      calls = calls_;
    }
    for (const auto& [other, call] : calls) {
      const std::shared_ptr<grpc::ClientContext> context = call.lock();
      if (other != place && context != nullptr) context->TryCancel();
    }
  }

  mutable std::mutex mutex_;
  std::optional<int> first_;
  std::vector<std::pair<int, std::weak_ptr<grpc::ClientContext>>> calls_;
};

}  // namespace dcloc::server
