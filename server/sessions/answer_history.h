#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// The last answers of a session, to be given again to scans that come again. Bounded: the oldest
/// one makes room. Not thread-safe.
class AnswerHistory {
 public:
  /// `capacity` >= 1.
  explicit AnswerHistory(int capacity) : entries_(static_cast<std::size_t>(capacity)) {}

  void Keep(std::int64_t sequence_number, const v1::LocalizeResponse& answer);

  /// Gives the newest answer to that number as it was; false when there is none (any more).
  bool Recall(std::int64_t sequence_number, v1::LocalizeResponse* answer) const;

 private:
  struct Entry {
    std::int64_t sequence_number = -1;
    std::string bytes;  ///< serialized: a third of a message's memory
  };

  std::vector<Entry> entries_;  ///< a ring
  std::size_t kept_count_ = 0;
};

}  // namespace dcloc::server
