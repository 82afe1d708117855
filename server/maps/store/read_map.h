#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/map/radar_map.h"
#include "server/base/files.h"
#include "server/base/sha256.h"

namespace dcloc::server {

/// The bytes of a map file in memory of this process alone, compared with their hash. NotFound;
/// DataLoss: they have another one; ResourceExhausted: there is not enough memory.
absl::StatusOr<std::vector<std::byte>> ReadMapFile(const std::filesystem::path& path,
                                                   absl::string_view sha256);

/// The same of a file that is open, from its beginning.
absl::StatusOr<std::vector<std::byte>> ReadMapFile(const FileDescriptor& file,
                                                   absl::string_view sha256);

/// The map that has these bytes, verified. DataLoss: they are no intact map.
absl::StatusOr<std::shared_ptr<const RadarMap>> MapOf(std::vector<std::byte> bytes);

/// Both: nobody can change a map in use or cut it short. Errors of `ReadMapFile` and `MapOf`.
absl::StatusOr<std::shared_ptr<const RadarMap>> ReadMap(const std::filesystem::path& path,
                                                        absl::string_view sha256);

/// Room for a map file. ResourceExhausted: there is not enough memory.
absl::StatusOr<std::vector<std::byte>> MemoryForMap(std::int64_t size_bytes);

/// OK, or DataLoss when what was hashed has another hash. Finishes `hash`.
absl::Status CheckMapHash(Sha256& hash, absl::string_view sha256);

/// Reads a file a piece at a time and compares its hash. NotFound; DataLoss: it has another hash.
/// `pace` is called with the size of each piece; when it returns false, Cancelled.
absl::Status CheckMapFile(const std::filesystem::path& path, absl::string_view sha256,
                          absl::FunctionRef<bool(std::size_t)> pace);

}  // namespace dcloc::server
