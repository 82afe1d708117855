#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/catalogue/hold.h"
#include "server/maps/store/incoming_files.h"

namespace dcloc::server {

/// What an upload will take of its tenant's storage.
struct StorageClaim {
  std::string tenant;
  std::string prefix;  ///< of the tenant's maps (Catalogue::ListMaps)
  std::string sha256;
  std::int64_t size_bytes = 0;
};

/// Shares out the storage of each tenant. Room is taken when an upload begins and given back when
/// it ends. A file counts once: as a version, as an upload under way with the size that it was
/// announced with, or as an unfinished one with the bytes that are there. These are counted anew
/// each time, so nothing has to survive a restart. Thread-safe; calls may block on storage.
class TenantQuota {
 public:
  /// Both outlive it.
  TenantQuota(Catalogue& catalogue, const IncomingFiles& incoming);

  /// Room for a file, until the result is destroyed; it may outlive this. `max_bytes` 0: no limit.
  /// ResourceExhausted names what the tenant has and the limit. InvalidArgument: the tenant has a
  /// file of that hash, of another size.
  absl::StatusOr<Hold> Reserve(const StorageClaim& claim, std::int64_t max_bytes);

 private:
  struct Claims;

  /// Bytes of uploads under way or unfinished, without the file of `claim` itself.
  absl::StatusOr<std::int64_t> PendingBytes(const StorageClaim& claim) const;

  Catalogue& catalogue_;
  const IncomingFiles& incoming_;
  const std::shared_ptr<Claims> claims_;  ///< shared with what was given out
};

}  // namespace dcloc::server
