#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::client {

/// What a session can go on with at any server of the fleet, should its own be gone: the newest
/// ticket, and the answered scans since the one that the ticket knows of. Not thread-safe.
class TicketKeeper {
 public:
  /// The scans of some seconds of a rig. Where more come without a newer ticket, the vehicle has
  /// not been tracked for long, and the ticket is worth nothing.
  static constexpr std::size_t kMaxScanCount = 512;

  void OnOpened(const v1::SessionOpened& opened);

  /// A scan has its answer; the newer ticket beside it, if there is one, replaces the last.
  void OnAnswered(const v1::Scan& scan, const v1::LocalizeResponse& answer);

  /// The highest epoch seen.
  std::int64_t epoch() const { return epoch_; }
  bool has_ticket() const { return ticket_.has_value(); }

  /// Puts into `open` what the next server needs to know.
  void Apply(v1::OpenSession* open) const;

  /// The next scan for a server that knows all up to `last_sequence_number`, oldest first; null
  /// after the newest. `index` is where to look, and is moved on.
  const v1::Scan* Next(std::int64_t last_sequence_number, std::size_t* index) const;

 private:
  bool keeps_ = false;  ///< the server hands out tickets
  std::int64_t epoch_ = 0;
  std::optional<v1::SessionTicket> ticket_;
  std::optional<std::int64_t> answered_;  ///< the highest number with a result
  /// Of the last answer; a ticket from before either changed is of a pose that was given up.
  std::int64_t reset_count_ = 0;
  std::int64_t map_version_ = 0;
  std::deque<v1::Scan> scans_;
};

}  // namespace dcloc::client
