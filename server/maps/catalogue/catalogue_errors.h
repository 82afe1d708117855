#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/catalogue.h"

/// The errors that `Catalogue` names: the same words from each implementation.
namespace dcloc::server {

absl::Status NoSuchMap(absl::string_view map_name);
absl::Status NoSuchVersion(absl::string_view map_name, std::int64_t version);
absl::Status NoActiveVersion(absl::string_view map_name);

absl::Status VersionInUse(absl::string_view map_name, std::int64_t version);
absl::Status VersionBeingDeleted(absl::string_view map_name);
absl::Status FileHeld(absl::string_view sha256, absl::string_view holder);

/// OK when a version has no label that keeps it.
absl::Status CheckMayBeDeleted(const MapRecord& map, std::int64_t version);

/// OK unless the version is the active one.
absl::Status CheckMayBeCanary(const MapRecord& map, std::int64_t version);

}  // namespace dcloc::server
