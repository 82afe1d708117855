#include "server/localization/slot_ring.h"

#include <utility>

namespace dcloc::server {

SlotRing::SlotRing(int max_pending_count)
    : max_pending_count_(max_pending_count),
      size_(static_cast<std::size_t>(max_pending_count)),
      slots_(1) {}

void SlotRing::Lengthen() {
  size_ += kDroppedSlots;
  if (answered_count_ > 0) slots_.resize(size_);
}

void SlotRing::OnAnswered() {
  if (answered_count_ == 0) slots_.resize(size_);
  ++answered_count_;
}

void SlotRing::OnRead() {
  Slot& slot = to_read();
  slot.arrival = Arrival::Now();
  slot.handling = Handling::kAnswer;
  ++read_count_;
}

void SlotRing::DropOldest(int taken_count) {
  const std::int64_t first = answered_count_ + taken_count;
  std::int64_t waiting = 0;
  const auto waits = [](const Slot& slot) {
    return slot.request.has_scan() && slot.handling == Handling::kAnswer;
  };
  for (std::int64_t i = first; i < read_count_; ++i) waiting += waits(At(i)) ? 1 : 0;
  for (std::int64_t i = first; waiting > max_pending_count_; ++i) {
    Slot& slot = At(i);
    if (!waits(slot)) continue;
    slot.handling = Handling::kDrop;
    --waiting;
    v1::LocalizeRequest header;  // the columns' memory goes
    header.mutable_scan()->set_sequence_number(slot.request.scan().sequence_number());
    slot.request = std::move(header);
  }
}

bool SlotRing::has_room() const {
  if (answered_count_ == 0) return read_count_ == 0;
  return read_count_ - written_count_ < static_cast<std::int64_t>(slots_.size());
}

}  // namespace dcloc::server
