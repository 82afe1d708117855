#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "dcloc/v1/localization_service.pb.h"
#include "server/base/clock.h"
#include "server/convert/session.h"
#include "server/identity/principal.h"
#include "server/tickets/served_ticket_keys.h"
#include "server/tickets/ticket_content.h"

namespace dcloc::server {

inline constexpr std::size_t kMaxTicketSize = 4096;

/// Whose ticket it is: a digest of principal, tenant, vehicle, map, rig and options. It is
/// associated data of what is sealed.
struct TicketBinding {
  std::string digest;
};
TicketBinding BindingOf(const Principal& principal, const v1::OpenSession& open);

/// What became of a ticket, and what it holds where it is accepted.
struct OpenedTicket {
  TicketUse use = TicketUse::kNone;
  TicketContent content;
  std::string key_id;  ///< the ticket's, where it has one
};

/// Makes and opens the tickets of sessions. Thread-safe; waits for nothing.
///
/// A ticket is "dct1", the key's id (a byte of length before it), the times of issue and expiry
/// [s, 8 bytes each, high byte first], the begin of the binding, then what TicketCipher makes.
class SessionTickets {
 public:
  /// Tickets hold for `lifetime`, and come about every `interval`.
  SessionTickets(std::unique_ptr<const ServedTicketKeys> keys, std::chrono::seconds lifetime,
                 std::chrono::nanoseconds interval)
      : keys_(std::move(keys)), lifetime_(lifetime), interval_(interval) {}

  /// About how often a session is to get one.
  std::chrono::nanoseconds interval() const { return interval_; }

  /// Issued at `now`. ResourceExhausted where it would be longer than `kMaxTicketSize`.
  absl::StatusOr<std::string> Seal(const TicketContent& content, const TicketBinding& binding,
                                   SystemTime now) const;

  /// Of any bytes that a client sends as a ticket.
  OpenedTicket Open(absl::string_view ticket, const TicketBinding& binding, SystemTime now) const;

 private:
  const std::unique_ptr<const ServedTicketKeys> keys_;
  const std::chrono::seconds lifetime_;
  const std::chrono::nanoseconds interval_;
};

}  // namespace dcloc::server
