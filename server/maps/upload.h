#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include "absl/strings/string_view.h"

#include "absl/status/statusor.h"
#include "server/maps/map_store.h"
#include "server/maps/sha256.h"

namespace dcloc::server {

/// What a client says of the file that it is about to send.
struct UploadRequest {
  std::string tenant;  ///< of who sends it
  std::string map_name;
  std::int64_t size_bytes = 0;
  std::string sha256;
  bool activate = false;
};

/// What an upload may take.
struct UploadLimits {
  std::int64_t max_map_bytes = 0;
  std::int64_t max_tenant_bytes = 0;  ///< of the tenant's versions together; 0: no limit
};

/// A map file on its way into the store: it lies in a temporary file until it is complete and was
/// verified, and is gone when the upload is dropped. Not thread-safe; calls block on storage.
class Upload {
 public:
  /// InvalidArgument names the field, the value and the bound, ResourceExhausted the limit that it
  /// would pass. `store` outlives the upload.
  static absl::StatusOr<Upload> Begin(MapStore& store, UploadRequest request,
                                      const UploadLimits& limits);
  Upload(Upload&&) noexcept;
  Upload& operator=(Upload&&) = delete;
  ~Upload();

  /// Appends bytes that begin at `offset_bytes` in the file. InvalidArgument unless that is where
  /// the bytes before ended and the file does not grow beyond its size.
  absl::Status Append(std::int64_t offset_bytes, absl::string_view bytes);

  /// Checks size, hash and the map in it, and adds it to the store. DataLoss when the bytes are not
  /// those that were announced, or are no intact map.
  absl::StatusOr<MapVersionRecord> Finish();

 private:
  Upload(MapStore& store, UploadRequest request, TemporaryFile file);

  MapStore* store_;
  UploadRequest request_;
  TemporaryFile file_;
  std::int64_t received_bytes_ = 0;
  Sha256 hash_;
};

}  // namespace dcloc::server
