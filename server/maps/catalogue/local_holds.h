#pragma once

#include <cstdint>
#include <memory>
#include <optional>
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

  Hold HoldVersion(absl::string_view map_name, std::int64_t version);

  /// As Catalogue::HoldFile.
  absl::StatusOr<Hold> HoldFile(absl::string_view sha256, absl::string_view holder);

  bool IsHeld(absl::string_view map_name, std::int64_t version) const;

  /// The newest version of a map that is held, if there is one.
  std::optional<std::int64_t> NewestHeld(absl::string_view map_name) const;

 private:
  struct State;
  std::shared_ptr<State> state_;  ///< shared with the holds, which may outlive this
};

}  // namespace dcloc::server
