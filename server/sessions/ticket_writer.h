#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "server/convert/answer.h"
#include "server/sessions/scan_localizer.h"
#include "server/sessions/session_info.h"
#include "server/tickets/session_tickets.h"

namespace dcloc::server {

/// Makes a session's tickets. Each is of the vehicle as it was an interval before: whoever goes on
/// from it gets the scans since then, which fill a sub-map. Not thread-safe.
class TicketWriter {
 public:
  /// `tickets` outlives it; null where there is no fleet key.
  TicketWriter(const SessionTickets* tickets, std::shared_ptr<const SessionInfo> info,
               TicketBinding binding)
      : tickets_(tickets), info_(std::move(info)), binding_(std::move(binding)) {}

  /// Only sessions that can be resumed get tickets, and none that is recorded: its recording could
  /// not be continued elsewhere.
  bool writes() const {
    return tickets_ != nullptr && info_->description.resumable() && !info_->recorded;
  }

  /// A scan was localized by `localizer` in `map`. Gives a ticket about once an interval by the
  /// scans' stamps. None where the vehicle has been found elsewhere since it was as the ticket
  /// would say.
  std::optional<AnswerTicket> OnAnswered(std::int64_t sequence_number, const LocalizedScan& scan,
                                         const MapVersionRecord& map, ScanLocalizer& localizer);

  /// The session goes on in another version of its map.
  void OnMoved() { pending_.reset(); }

 private:
  std::optional<AnswerTicket> Seal(const TicketContent& content) const;

  const SessionTickets* tickets_;
  std::shared_ptr<const SessionInfo> info_;
  TicketBinding binding_;
  std::optional<Stamp> last_look_;
  std::optional<TicketContent> pending_;  ///< of the last look
};

}  // namespace dcloc::server
