#include "client/sdk/outbox.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::client {

absl::StatusOr<v1::Scan> Outbox::TakeAnswer(std::int64_t sequence_number) {
  if (sent_count_ == 0) {
    return absl::DataLossError(
        absl::StrCat("the server answered scan ", sequence_number, ", and none was due"));
  }
  if (scans_.front().sequence_number() != sequence_number) {
    return absl::DataLossError(absl::StrCat("the server answered scan ", sequence_number, "; scan ",
                                            scans_.front().sequence_number(), " was due"));
  }
  v1::Scan scan = std::move(scans_.front());
  scans_.pop_front();
  --sent_count_;
  return scan;
}

}  // namespace dcloc::client
