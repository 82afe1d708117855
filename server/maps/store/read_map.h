#pragma once

#include <filesystem>
#include <memory>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/radar_map.h"

namespace dcloc::server {

/// Reads a map file into memory of this process alone and verifies it there, so that nobody can
/// change a map in use or cut it short. NotFound; DataLoss: the bytes have another hash, or are no
/// intact map; ResourceExhausted: there is not enough memory.
absl::StatusOr<std::shared_ptr<const RadarMap>> ReadMap(const std::filesystem::path& path,
                                                        absl::string_view sha256);

/// Reads a file a piece at a time and compares its hash. NotFound; DataLoss: it has another hash.
/// `pace` is called with the size of each piece; when it returns false, Cancelled.
absl::Status CheckMapFile(const std::filesystem::path& path, absl::string_view sha256,
                          absl::FunctionRef<bool(std::size_t)> pace);

}  // namespace dcloc::server
