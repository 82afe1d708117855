#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "core/radar/stamp.h"

namespace dcloc::server {

/// Checks the order of a session's scans by their sequence numbers. Stamps may jump; the localizer
/// decides what that means. Not thread-safe.
class SequenceNumberCheck {
 public:
  /// OutOfRange when a scan with this number or a higher one has been localized.
  absl::Status Check(std::int64_t sequence_number) const;

  /// Goes on after a scan that another session localized. Before the first one.
  void Restore(std::int64_t sequence_number, Stamp stamp);

  /// To be called when a scan was localized; returns how many numbers before it are missing.
  std::int64_t OnLocalized(std::int64_t sequence_number, Stamp stamp);

  /// To be called when a scan was dropped; returns how many numbers before it are missing.
  std::int64_t OnDropped(std::int64_t sequence_number);

  /// The highest number localized; -1 before the first one.
  std::int64_t last_localized() const { return last_localized_; }

  /// Of the newest scan localized.
  const std::optional<Stamp>& last_stamp() const { return last_stamp_; }

 private:
  std::int64_t last_localized_ = -1;
  std::int64_t highest_ = -1;  ///< localized or dropped
  std::optional<Stamp> last_stamp_;
};

}  // namespace dcloc::server
