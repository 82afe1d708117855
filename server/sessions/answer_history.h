#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "server/convert/answer.h"

namespace dcloc::server {

/// The last answers of a session, for scans that are sent again. Bounded: the oldest one is
/// dropped. Not thread-safe.
class AnswerHistory {
 public:
  /// `capacity` >= 1. Memory is taken as answers come.
  explicit AnswerHistory(int capacity) : capacity_(static_cast<std::size_t>(capacity)) {}

  void Keep(const ScanAnswer& answer);

  /// The newest answer to that number, valid until the next `Keep`; null when there is none (any
  /// more).
  const ScanAnswer* Recall(std::int64_t sequence_number) const;

 private:
  const std::size_t capacity_;
  std::deque<ScanAnswer> answers_;  ///< a ring once it is full
  std::size_t kept_count_ = 0;
};

}  // namespace dcloc::server
