#pragma once

#include <cstddef>
#include <deque>

#include "absl/status/statusor.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// What of a session is not answered yet, scans and position fixes in their order: what was sent on
/// the stream that is open, then what waits. Scans are kept until they are answered, since the next
/// stream must send them again. A fix is sent once. Not thread-safe.
class Outbox {
 public:
  void Push(v1::Scan scan);
  void Push(v1::PositionFix fix);

  /// The next one to send, a `scan` or a `position_fix`; null when there is none.
  const v1::LocalizeRequest* Next() const {
    return sent_count_ < requests_.size() ? &requests_[sent_count_] : nullptr;
  }

  /// `Next` has been sent.
  void MarkSent();

  /// The oldest one that was sent has been answered, and is given back; DataLoss when that is not
  /// the answer's.
  absl::StatusOr<v1::LocalizeRequest> TakeAnswer(const v1::LocalizeResponse& answer);

  /// There is a new stream: all scans are to be sent again. Returns how many fixes had been sent;
  /// those are forgotten, as they may have been used.
  std::size_t Rewind();

  /// Forgets all fixes, and returns how many there were; nothing may have been sent since `Rewind`.
  std::size_t DropFixes();

  bool empty() const { return requests_.empty(); }
  std::size_t scan_count() const { return requests_.size() - fix_count_; }
  std::size_t fix_count() const { return fix_count_; }
  std::size_t sent_scan_count() const { return sent_scan_count_; }
  std::size_t waiting_scan_count() const { return scan_count() - sent_scan_count_; }

 private:
  std::size_t EraseFixes(std::size_t count);

  std::deque<v1::LocalizeRequest> requests_;
  std::size_t sent_count_ = 0;
  std::size_t sent_scan_count_ = 0;
  std::size_t fix_count_ = 0;
};

}  // namespace dcloc::client
