#include "client/sdk/ticket_keeper.h"

#include <algorithm>
#include <utility>

namespace dcloc::client {

void TicketKeeper::OnOpened(const v1::SessionOpened& opened) {
  epoch_ = std::max(epoch_, opened.epoch());
  keeps_ = opened.ticket_interval_ns() > 0;
  const bool goes_on = opened.resumed() || opened.ticket_use() == v1::TICKET_USE_ACCEPTED;
  if (keeps_ && goes_on) return;
  // Of another session than this one, which begins anew.
  ticket_.reset();
  answered_.reset();
  scans_.clear();
}

void TicketKeeper::OnAnswered(const v1::Scan& scan, const v1::LocalizeResponse& answer) {
  // A rejected one is not sent again to catch up, and others below it may still be unanswered.
  if (answer.has_result()) {
    answered_ = std::max(answered_.value_or(scan.sequence_number()), scan.sequence_number());
  }
  if (!keeps_) return;
  if (answer.has_result() && !answer.from_memory()) {
    const v1::LocalizationResult& result = answer.result();
    if (result.resets().count() != reset_count_ || result.map_version() != map_version_) {
      ticket_.reset();
    }
    reset_count_ = result.resets().count();
    map_version_ = result.map_version();
    scans_.push_back(scan);
  }
  if (answer.has_ticket()) {
    ticket_ = answer.ticket();
    std::erase_if(scans_, [this](const v1::Scan& kept) {
      return kept.sequence_number() <= ticket_->last_sequence_number();
    });
  }
  if (scans_.size() <= kMaxScanCount) return;
  ticket_.reset();
  scans_.pop_front();
}

void TicketKeeper::Apply(v1::OpenSession* open) const {
  open->set_epoch(epoch_);
  if (!ticket_) return;
  open->set_ticket(ticket_->sealed());
  if (answered_) open->set_answered_sequence_number(*answered_);
}

const v1::Scan* TicketKeeper::Next(std::int64_t last_sequence_number, std::size_t* index) const {
  while (*index < scans_.size()) {
    const v1::Scan& scan = scans_[(*index)++];
    if (scan.sequence_number() > last_sequence_number) return &scan;
  }
  return nullptr;
}

}  // namespace dcloc::client
