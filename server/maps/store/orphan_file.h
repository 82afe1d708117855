#pragma once

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// Removes a map file that no version has any more, as its last one was deleted; returns whether it
/// was removed. The file stays if a version has it, or if it is held (Catalogue::HoldFile): then
/// another process is storing it and will add its version. Files of a process that died while
/// storing them are not held any more.
absl::StatusOr<bool> RemoveOrphan(Catalogue& catalogue, MapFiles& files, absl::string_view sha256,
                                  absl::string_view holder);

/// The same for a file of which nobody asked to be rid: sets it aside.
absl::StatusOr<bool> QuarantineOrphan(Catalogue& catalogue, MapFiles& files,
                                      absl::string_view sha256, absl::string_view holder);

}  // namespace dcloc::server
