#include "server/sessions/sequence_number_check.h"

#include "absl/strings/str_format.h"

namespace dcloc::server {
absl::Status SequenceNumberCheck::Check(std::int64_t sequence_number) const {
  if (sequence_number <= last_localized_) {
    return absl::OutOfRangeError(absl::StrFormat(
        "scan.sequence_number is %d, which is late: %d has been processed, and no answer to the "
        "late one is in memory",
        sequence_number, last_localized_));
  }
  return absl::OkStatus();
}

void SequenceNumberCheck::Restore(std::int64_t sequence_number, Stamp stamp) {
  last_localized_ = highest_ = sequence_number;
  last_stamp_ = stamp;
}

std::int64_t SequenceNumberCheck::OnLocalized(std::int64_t sequence_number, Stamp stamp) {
  last_localized_ = sequence_number;
  last_stamp_ = stamp;
  return OnDropped(sequence_number);
}

std::int64_t SequenceNumberCheck::OnDropped(std::int64_t sequence_number) {
  if (sequence_number <= highest_) return 0;
  const std::int64_t missing = highest_ < 0 ? 0 : sequence_number - highest_ - 1;
  highest_ = sequence_number;
  return missing;
}

}  // namespace dcloc::server
