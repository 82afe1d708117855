#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/hold.h"

namespace dcloc::server {

/// The holds of a catalogue that only one process has open. They are in its memory and end with it.
/// A catalogue that several processes share must keep its holds where all of them see them.
/// Thread-safe; no call waits for storage.
class LocalHolds {
 public:
  LocalHolds();

  /// Unavailable while the version is barred.
  absl::StatusOr<Hold> HoldVersion(absl::string_view map_name, std::int64_t version);

  /// As Catalogue::HoldFile.
  absl::StatusOr<Hold> HoldFile(absl::string_view sha256, absl::string_view holder);

  /// Keeps a version from being held while it is deleted. FailedPrecondition when it is held;
  /// Unavailable when it is barred already.
  absl::StatusOr<Hold> BarVersion(absl::string_view map_name, std::int64_t version);

  /// The same for all versions of a map.
  absl::StatusOr<Hold> BarMap(absl::string_view map_name);

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared with the holds, which may outlive this
};

}  // namespace dcloc::server
