#include "server/localization/slot_ring.h"

#include <utility>

namespace dcloc::server {

SlotRing::SlotRing(int max_pending_count)
    : max_pending_count_(max_pending_count),
      size_(static_cast<std::size_t>(max_pending_count)),
      slots_(1) {}

void SlotRing::Lengthen() {
  drops_ = true;
  size_ += kDroppedSlots;
  if (answered_count_ > 0) slots_.resize(size_);
}

void SlotRing::OnAnswered() {
  if (answered_count_ == 0) slots_.resize(size_);
  ++answered_count_;
}

void SlotRing::OnRead(std::size_t size_bytes) {
  Slot& slot = to_read();
  slot.size_bytes = size_bytes;
  pending_bytes_ += size_bytes;
  slot.arrival = Arrival::Now();
  slot.handling = Handling::kAnswer;
  ++read_count_;
}

void SlotRing::OnWritten() {
  Slot& slot = to_write();
  pending_bytes_ -= slot.size_bytes;
  if (slot.size_bytes > kMaxKeptBytes) slot.request = v1::LocalizeRequest();
  ++written_count_;
}

void SlotRing::DropOldest(int taken_count) {
  const std::int64_t first = answered_count_ + taken_count;
  std::int64_t waiting = 0;
  std::size_t waiting_bytes = 0;
  const auto waits = [](const Slot& slot) {
    return slot.request.has_scan() && slot.handling == Handling::kAnswer;
  };
  for (std::int64_t i = first; i < read_count_; ++i) {
    if (!waits(At(i))) continue;
    ++waiting;
    waiting_bytes += At(i).size_bytes;
  }
  const auto is_too_much = [&] {
    return waiting > max_pending_count_ || (waiting > 1 && waiting_bytes > kMaxWaitingBytes);
  };
  for (std::int64_t i = first; is_too_much(); ++i) {
    Slot& slot = At(i);
    if (!waits(slot)) continue;
    slot.handling = Handling::kDrop;
    --waiting;
    waiting_bytes -= slot.size_bytes;
    pending_bytes_ -= std::exchange(slot.size_bytes, 0);
    v1::LocalizeRequest header;  // the columns' memory goes
    header.mutable_scan()->set_sequence_number(slot.request.scan().sequence_number());
    slot.request = std::move(header);
  }
}

bool SlotRing::has_room() const {
  if (answered_count_ == 0) return read_count_ == 0;
  if (!drops_ && pending_bytes_ >= kMaxWaitingBytes) return false;
  return read_count_ - written_count_ < static_cast<std::int64_t>(slots_.size());
}

}  // namespace dcloc::server
