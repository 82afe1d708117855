#include "server/sessions/answer_history.h"

#include <algorithm>

namespace dcloc::server {

void AnswerHistory::Keep(std::int64_t sequence_number, const v1::LocalizeResponse& answer) {
  Entry& entry = entries_[kept_count_++ % entries_.size()];
  entry.sequence_number = sequence_number;
  answer.SerializeToString(&entry.bytes);
}

bool AnswerHistory::Recall(std::int64_t sequence_number, v1::LocalizeResponse* answer) const {
  const std::size_t count = std::min(kept_count_, entries_.size());
  for (std::size_t age = 1; age <= count; ++age) {
    const Entry& entry = entries_[(kept_count_ - age) % entries_.size()];
    if (entry.sequence_number == sequence_number) return answer->ParseFromString(entry.bytes);
  }
  return false;
}

}  // namespace dcloc::server
