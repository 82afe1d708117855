#pragma once

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// Removes a map file that no version has, and gives whether it did. The file stays while a version
/// has it, and while anyone holds it (Catalogue::HoldFile): then another process is storing it, and
/// adds its version next. What a process that died while it stored a file left behind is held by
/// nobody any more.
absl::StatusOr<bool> RemoveOrphan(Catalogue& catalogue, MapFiles& files, absl::string_view sha256,
                                  absl::string_view holder);

}  // namespace dcloc::server
