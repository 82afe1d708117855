#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/base/ticker.h"
#include "server/tickets/ticket_cipher.h"

namespace dcloc::server {

/// The fleet's keys that a running server uses: the last ones of their file that were good, as
/// ServedCertificates has it for certificates. Thread-safe; `cipher` waits for nothing.
class ServedTicketKeys {
 public:
  /// Looks at the file every second from then on. InvalidArgument says what is wrong with it.
  static absl::StatusOr<std::unique_ptr<ServedTicketKeys>> Load(const std::filesystem::path& file);

  std::shared_ptr<const TicketCipher> cipher() const { return cipher_.load(); }

  /// Takes new keys, if they are good. A file is looked at twice before it is judged, so as not to
  /// judge half of a change. By one thread.
  void Refresh();

 private:
  ServedTicketKeys(std::filesystem::path file, std::shared_ptr<const TicketCipher> cipher);

  void Take(const absl::StatusOr<std::vector<TicketKey>>& found);

  const std::filesystem::path file_;
  std::atomic<std::shared_ptr<const TicketCipher>> cipher_;
  absl::StatusOr<std::vector<TicketKey>> last_look_;  ///< the refreshing thread's
  absl::Status last_fault_;                           ///< the refreshing thread's
  std::unique_ptr<Ticker> ticker_;                    ///< last: it uses the others
};

}  // namespace dcloc::server
