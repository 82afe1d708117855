#pragma once

#include <utility>

#include "absl/functional/any_invocable.h"

namespace dcloc::server {

/// A hold of a version or file in the catalogue (Catalogue::HoldVersion, HoldFile); given back when
/// this is destroyed. Giving back never waits for storage, so it may happen on any thread. An
/// implementation that has to tell a database does so later, from a thread of its own. A hold may
/// outlive its catalogue. Not thread-safe.
class Hold {
 public:
  Hold() = default;  ///< holds nothing
  explicit Hold(absl::AnyInvocable<void()> give_back) : give_back_(std::move(give_back)) {}
  Hold(Hold&& other) noexcept : give_back_(std::exchange(other.give_back_, nullptr)) {}
  Hold& operator=(Hold other) noexcept {
    std::swap(give_back_, other.give_back_);
    return *this;
  }
  ~Hold() {
    if (give_back_) give_back_();
  }

 private:
  absl::AnyInvocable<void()> give_back_;
};

}  // namespace dcloc::server
