#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/base/single_flight.h"
#include "server/maps/store/map_cache.h"
#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// Map files of a storage that is far, read through a cache on this host. A file that is in the
/// cache is read from there, also while the storage is away; of several calls that ask for one file
/// at once, one reads it. All else, `Check` among it, asks the storage.
class CachedMapFiles final : public MapFiles {
 public:
  CachedMapFiles(std::unique_ptr<MapFiles> files, std::shared_ptr<MapCache> cache);

  absl::Status Keep(const std::filesystem::path& path, absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::byte>> Read(absl::string_view sha256) override;
  absl::StatusOr<std::shared_ptr<const RadarMap>> Open(absl::string_view sha256) override;
  absl::Status Check(absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) override;
  absl::Status Remove(absl::string_view sha256) override;
  absl::Status Quarantine(absl::string_view sha256) override;
  absl::StatusOr<int> RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                              std::chrono::nanoseconds limit) override;
  absl::StatusOr<int> QuarantinedCount() override;
  absl::StatusOr<std::int64_t> SizeOf(absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::string>> List() override;

 private:
  const std::unique_ptr<MapFiles> files_;
  const std::shared_ptr<MapCache> cache_;
  SingleFlight<std::shared_ptr<const RadarMap>> openings_;
};

}  // namespace dcloc::server
