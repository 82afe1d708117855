#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/map/map_parts.h"

namespace dcloc::cli {

/// A map file, verified whole. Errors name the file.
absl::StatusOr<MapParts> ReadMapParts(const std::string& file);

/// Writes the map whole and gives what it is. Errors name the file.
absl::StatusOr<MapInfo> WriteMapParts(const MapParts& map, const std::string& file);

}  // namespace dcloc::cli
