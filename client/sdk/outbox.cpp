#include "client/sdk/outbox.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::client {
namespace {

std::string NameOf(const v1::LocalizeRequest& request) {
  return request.has_scan() ? absl::StrCat("scan ", request.scan().sequence_number())
                            : absl::StrCat("the fix of ", request.position_fix().stamp_ns());
}

std::string NameOf(const v1::LocalizeResponse& answer) {
  if (answer.has_position_fix_answer()) {
    return absl::StrCat("the fix of ", answer.position_fix_answer().stamp_ns());
  }
  return absl::StrCat("scan ", answer.has_result() ? answer.result().sequence_number()
                                                   : answer.rejected().sequence_number());
}

}  // namespace

void Outbox::Push(v1::Scan scan) { *requests_.emplace_back().mutable_scan() = std::move(scan); }

void Outbox::Push(v1::PositionFix fix) {
  *requests_.emplace_back().mutable_position_fix() = std::move(fix);
  ++fix_count_;
}

void Outbox::MarkSent() {
  if (Next()->has_scan()) ++sent_scan_count_;
  ++sent_count_;
}

absl::StatusOr<v1::LocalizeRequest> Outbox::TakeAnswer(const v1::LocalizeResponse& answer) {
  if (sent_count_ == 0) {
    return absl::DataLossError(
        absl::StrCat("the server answered ", NameOf(answer), ", and none was due"));
  }
  const std::string due = NameOf(requests_.front());
  if (due != NameOf(answer)) {
    return absl::DataLossError(
        absl::StrCat("the server answered ", NameOf(answer), "; ", due, " was due"));
  }
  v1::LocalizeRequest request = std::move(requests_.front());
  requests_.pop_front();
  --sent_count_;
  if (request.has_scan()) --sent_scan_count_;
  if (request.has_position_fix()) --fix_count_;
  return request;
}

std::size_t Outbox::Rewind() {
  const std::size_t lost = EraseFixes(sent_count_);
  sent_count_ = sent_scan_count_ = 0;
  return lost;
}

std::size_t Outbox::DropFixes() { return EraseFixes(requests_.size()); }

/// Of the first `count` requests.
std::size_t Outbox::EraseFixes(std::size_t count) {
  const auto end = std::next(requests_.begin(), static_cast<std::ptrdiff_t>(count));
  const auto kept = std::remove_if(requests_.begin(), end, [](const v1::LocalizeRequest& request) {
    return request.has_position_fix();
  });
  const auto erased = static_cast<std::size_t>(std::distance(kept, end));
  requests_.erase(kept, end);
  fix_count_ -= erased;
  return erased;
}

}  // namespace dcloc::client
