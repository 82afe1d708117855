#pragma once

#include <map>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "core/radar/scan.h"

namespace dcloc {

/// The order that a vehicle's scans must come in: those of one radar have rising stamps, those of
/// different radars do not go back.
class StampOrder {
 public:
  /// OK when `scan` may follow those accepted so far; else InvalidArgument with both stamps.
  absl::Status Check(const Scan& scan) const;

  void Accept(const Scan& scan) { newest_ = newest_of_radar_[scan.radar_id] = scan.stamp; }

 private:
  std::optional<Stamp> newest_;
  std::map<std::string, Stamp> newest_of_radar_;
};

}  // namespace dcloc
