#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "absl/status/statusor.h"
#include "dcloc/v1/scan.pb.h"

namespace dcloc::client {

/// The scans of a session that are not answered yet, in their order: those sent on the stream that
/// is open, then those that wait. They are kept until they are answered, since the next stream must
/// send them again. Not thread-safe.
class Outbox {
 public:
  void Push(v1::Scan scan) { scans_.push_back(std::move(scan)); }

  /// The next one to send; null when there is none.
  const v1::Scan* Next() const {
    return sent_count_ < scans_.size() ? &scans_[sent_count_] : nullptr;
  }

  /// `Next` has been sent.
  void MarkSent() { ++sent_count_; }

  /// The oldest one that was sent has been answered, and is given back; DataLoss when that is not
  /// the answer's.
  absl::StatusOr<v1::Scan> TakeAnswer(std::int64_t sequence_number);

  /// There is a new stream: all are to be sent again.
  void Rewind() { sent_count_ = 0; }

  bool empty() const { return scans_.empty(); }
  std::size_t size() const { return scans_.size(); }
  std::size_t sent_count() const { return sent_count_; }
  std::size_t waiting_count() const { return scans_.size() - sent_count_; }

 private:
  std::deque<v1::Scan> scans_;
  std::size_t sent_count_ = 0;
};

}  // namespace dcloc::client
