#include "server/sessions/answer_history.h"

namespace dcloc::server {

void AnswerHistory::Keep(const ScanAnswer& answer) {
  if (answers_.size() < capacity_) {
    answers_.push_back(answer);
  } else {
    answers_[kept_count_ % capacity_] = answer;
  }
  ++kept_count_;
}

const ScanAnswer* AnswerHistory::Recall(std::int64_t sequence_number) const {
  for (std::size_t age = 1; age <= answers_.size(); ++age) {
    const ScanAnswer& answer = answers_[(kept_count_ - age) % capacity_];
    if (answer.sequence_number == sequence_number) return &answer;
  }
  return nullptr;
}

}  // namespace dcloc::server
