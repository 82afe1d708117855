#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/server/maps/store/map_store_fixture.h"

namespace dcloc::server {

inline constexpr std::int64_t kMaxMapBytes = 1 << 20;
inline constexpr UploadLimits kLimits{.max_map_bytes = kMaxMapBytes};

inline int CountFiles(const std::filesystem::path& folder) {
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    count += entry.is_regular_file() ? 1 : 0;
  }
  return count;
}

/// A store that takes small maps, and how many files it has.
class MapStoreTest : public StoreFixture {
 protected:
  absl::StatusOr<MapVersionRecord> Put(const std::vector<std::byte>& bytes,
                                       const UploadRequest& request) {
    absl::StatusOr<Upload> upload = Upload::Begin(*store_, request, kLimits);
    if (!upload.ok()) return upload.status();
    constexpr std::size_t kPart = 1000;
    for (std::size_t offset = 0; offset < bytes.size(); offset += kPart) {
      const auto part = TextOf(bytes).substr(offset, kPart);
      absl::Status status = upload->Append(static_cast<std::int64_t>(offset), part);
      if (!status.ok()) return status;
    }
    return upload->Finish();
  }

  absl::StatusOr<MapVersionRecord> Put(const std::vector<std::byte>& bytes) {
    return Put(bytes, RequestFor(bytes));
  }

  absl::StatusOr<MapVersionRecord> PutAs(const std::string& map_name,
                                         const std::vector<std::byte>& bytes) {
    UploadRequest request = RequestFor(bytes);
    request.map_name = map_name;
    return Put(bytes, request);
  }

  int FileCount() const { return CountFiles(folder_.path() / "maps"); }
  int IncomingCount() const { return CountFiles(folder_.path() / "incoming"); }
};

}  // namespace dcloc::server
