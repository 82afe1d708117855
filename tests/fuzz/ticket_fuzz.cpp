#include "server/tickets/session_tickets.h"

#include <google/protobuf/stubs/logging.h>

#include <memory>
#include <string>

#include "server/tickets/ticket_content.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/server/tickets/ticket_fixture.h"

namespace dcloc {
namespace {

/// A server's, with a key of its own.
const server::SessionTickets& Tickets() {
  static const server::KeyFile file(server::KeyLine("first", '1'));
  static const std::unique_ptr<server::SessionTickets> tickets = file.Tickets();
  return *tickets;
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  google::protobuf::SetLogHandler(nullptr);  // it prints a line for each text that is no UTF-8
  const server::TicketContent content = server::SomeContent();
  server::TicketContent early = content;
  early.snapshot.known = {};
  const std::string ticket = *Tickets().Seal(content, server::SomeBinding(), server::kTicketNow);
  Require(Tickets().Open(ticket, server::SomeBinding(), server::kTicketNow).use ==
              server::TicketUse::kAccepted,
          "the seed is valid");
  return {InputOf(*server::WriteTicketContent(content, server::kMaxTicketSize)),
          InputOf(*server::WriteTicketContent(early, server::kMaxTicketSize)), InputOf(ticket)};
}

}  // namespace dcloc

// As what is sealed in a ticket, and as the ticket.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace server = dcloc::server;
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const server::OpenedTicket opened =
      dcloc::Tickets().Open(bytes, server::SomeBinding(), server::kTicketNow);
  static_cast<void>(opened);
  const auto content = server::ReadTicketContent(bytes);
  if (!content.ok()) return 0;
  // What was read can be sealed, and is then read as it was.
  const auto written = server::WriteTicketContent(*content, std::size_t{1} << 20);
  dcloc::Require(written.ok(), "what was read can be written");
  const auto again = server::ReadTicketContent(*written);
  dcloc::Require(again.ok(), "what was written can be read");
  dcloc::Require(*server::WriteTicketContent(*again, std::size_t{1} << 20) == *written,
                 "a content is read as written");
  return 0;
}
