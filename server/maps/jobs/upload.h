#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/store/incoming_files.h"
#include "server/maps/store/map_store.h"

namespace dcloc::server {

/// What a client says of the file that it is about to send.
struct UploadRequest {
  std::string tenant;  ///< of who sends it
  std::string map_name;
  std::int64_t size_bytes = 0;
  std::string sha256;
  bool activate = false;
};

/// Bounds of an upload.
struct UploadLimits {
  std::int64_t max_map_bytes = 0;
  std::int64_t max_tenant_bytes =
      0;  ///< of the tenant's versions and uploads together; 0: no limit
};

/// One upload of a map file into the store. If it is dropped, the bytes received stay, and another
/// upload can continue with them. They are removed once the file is a version, or turns out to be
/// invalid. Not thread-safe; calls block on storage. Aborted once another upload has taken the same
/// file.
class Upload {
 public:
  /// InvalidArgument names the field, the value and the bound, ResourceExhausted the limit that it
  /// would pass. `store` outlives the upload.
  static absl::StatusOr<Upload> Begin(MapStore& store, UploadRequest request,
                                      const UploadLimits& limits);

  /// Appends bytes that begin at `offset_bytes` in the file. The first call may begin anywhere in
  /// the bytes of an earlier upload, or at their end; each later call where the one before ended.
  /// InvalidArgument otherwise, or if the file would exceed its announced size.
  absl::Status Append(std::int64_t offset_bytes, absl::string_view bytes);

  /// Checks size, hash and the map in it, adds it to the store, and activates it if that was asked
  /// for. DataLoss when the bytes are not those that were announced, or are no intact map. If
  /// nothing was appended, the file may be one that the tenant has in the store already.
  absl::StatusOr<MapVersionRecord> Finish();

 private:
  Upload(MapStore& store, UploadRequest request, Hold room, IncomingFile file);

  absl::Status BeginAt(std::int64_t offset_bytes);
  /// The version, and its map if this upload stored it.
  absl::StatusOr<LoadedMap> Take();

  MapStore* store_;
  UploadRequest request_;
  Hold room_;  ///< of the tenant's storage
  IncomingFile file_;
};

}  // namespace dcloc::server
