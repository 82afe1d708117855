#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dcloc/v1/localization_service.pb.h"
#include "server/sessions/session.h"

namespace dcloc::server {

/// What becomes of a message.
enum class Handling {
  kAnswer,   ///< it is worked on and answered
  kDrop,     ///< newer scans wait: it is answered, but not looked at
  kCatchUp,  ///< its answer was another session's: it is localized for those that follow, never
             ///< dropped
  kSilent,   ///< it needs no answer
};

/// A message and its answer; the memory of both is reused, unless it is large.
struct Slot {
  v1::LocalizeRequest request;
  std::size_t size_bytes = 0;  ///< of the message as it came; 0 once it is dropped
  v1::LocalizeResponse response;
  Arrival arrival;
  Handling handling = Handling::kAnswer;
};

/// A stream's messages, in order: each is read, answered and written, then its slot is free again.
/// Bounded in number and in bytes, so that neither a fast sender, one of large messages, nor a slow
/// reader makes the server's memory grow. Not thread-safe.
class SlotRing {
 public:
  /// Messages that wait have this size together at most, but for the one that comes last.
  static constexpr std::size_t kMaxWaitingBytes = std::size_t{1} << 20;

  /// `max_pending_count` >= 1: messages that are read but not yet written. Until the first message,
  /// the opening, is answered there is one slot.
  explicit SlotRing(int max_pending_count);

  /// Makes the ring longer, for a stream that drops its oldest messages: answers of dropped ones
  /// wait behind the scan that is being localized. No slot may be in use.
  void Lengthen();

  /// The slot of the next message to be read, answered or written; and functions to say that this
  /// is done.
  Slot& to_read() { return At(read_count_); }
  Slot& newest_read() { return At(read_count_ - 1); }
  Slot& to_answer() { return At(answered_count_); }
  Slot& to_write() { return At(written_count_); }
  void OnRead(std::size_t size_bytes);
  void OnAnswered();
  void OnWritten();

  /// Frees the slots of messages that need no answer, as far as they are next to be written.
  void PassSilent() {
    while (has_answer_to_write() && to_write().handling == Handling::kSilent) OnWritten();
  }

  /// Marks the oldest of the waiting scans as dropped until at most `max_pending_count` are left,
  /// of `kMaxWaitingBytes` or only one; other messages are not dropped, and drop none. So many of
  /// the oldest messages, `taken_count`, are being answered and do not wait.
  void DropOldest(int taken_count);

  /// Whether a message may be read: only one before the first one is answered, then as many as
  /// there are slots, and in a ring that drops none as many as have `kMaxWaitingBytes`.
  bool has_room() const;
  bool none_read() const { return read_count_ == 0; }
  bool any_written() const { return written_count_ > 0; }
  bool has_answer_to_write() const { return written_count_ < answered_count_; }
  bool all_read_is_written() const { return written_count_ == read_count_; }

 private:
  /// For answers of dropped scans.
  static constexpr std::size_t kDroppedSlots = 64;
  /// Of a message whose memory is kept for another.
  static constexpr std::size_t kMaxKeptBytes = std::size_t{64} << 10;

  Slot& At(std::int64_t index) { return slots_[static_cast<std::size_t>(index) % slots_.size()]; }

  const std::int64_t max_pending_count_;
  std::size_t size_;  ///< once the opening is answered
  bool drops_ = false;
  std::size_t pending_bytes_ = 0;  ///< of messages that are read but not yet written
  std::vector<Slot> slots_;
  // written <= answered <= read.
  std::int64_t read_count_ = 0;
  std::int64_t answered_count_ = 0;
  std::int64_t written_count_ = 0;
};

}  // namespace dcloc::server
