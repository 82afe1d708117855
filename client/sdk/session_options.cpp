#include "client/sdk/session_options.h"

#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

absl::Status CheckCount(const char* field, std::size_t count) {
  if (count > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(field, " is 0; it must be at least 1"));
}

absl::Status CheckPositive(const char* field, std::chrono::milliseconds duration) {
  if (duration.count() > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", duration.count(), " ms; it must be positive"));
}

}  // namespace

absl::Status Validate(const SessionOptions& options) {
  absl::Status status = CheckCount("max_queued_scan_count", options.max_queued_scan_count);
  status.Update(CheckCount("max_unread_answer_count", options.max_unread_answer_count));
  status.Update(CheckCount("max_unanswered_scan_count", options.max_unanswered_scan_count));
  status.Update(CheckCount("max_unanswered_fix_count", options.max_unanswered_fix_count));
  status.Update(CheckPositive("open_timeout", options.open_timeout));
  status.Update(Validate(options.pose));
  if (status.ok() && options.unread_answers == UnreadAnswers::kForgetOldest &&
      !options.record_file.empty()) {
    return absl::InvalidArgumentError(
        "record_file is given and unread_answers is kForgetOldest; answers are recorded as they "
        "are taken, so that none may be forgotten");
  }
  if (!status.ok() || !options.reconnect) return status;
  const ReconnectOptions& reconnect = *options.reconnect;
  status.Update(CheckPositive("reconnect.initial_backoff", reconnect.initial_backoff));
  status.Update(CheckPositive("reconnect.give_up_after", reconnect.give_up_after));
  if (status.ok() && reconnect.max_backoff < reconnect.initial_backoff) {
    return absl::InvalidArgumentError(absl::StrCat(
        "reconnect.max_backoff is ", reconnect.max_backoff.count(),
        " ms; it must be at least initial_backoff, ", reconnect.initial_backoff.count(), " ms"));
  }
  return status;
}

}  // namespace dcloc::client
