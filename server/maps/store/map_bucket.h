#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/maps/store/map_files.h"
#include "server/maps/store/served_ages.h"
#include "server/objects/object_store.h"

namespace dcloc::server {

/// Map files in an object store, under the names that they have in a shared folder:
/// `maps/ab/ab12....dcmap`, `quarantine/ab12....dcmap`, `quarantine.ages`.
///
/// Several processes may share it. Who keeps, removes or sets aside a file holds it in the
/// catalogue (Catalogue::HoldFile), and one process at a time calls `RemoveExpiredQuarantine`.
class MapBucket final : public MapFiles {
 public:
  explicit MapBucket(std::shared_ptr<ObjectStore> objects);

  /// Reads back what was stored before it says so: a service need not compare hashes.
  absl::Status Keep(const std::filesystem::path& path, absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::byte>> Read(absl::string_view sha256) override;
  absl::Status Check(absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) override;
  absl::Status Remove(absl::string_view sha256) override;
  absl::Status Quarantine(absl::string_view sha256) override;
  absl::StatusOr<int> RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                              std::chrono::nanoseconds limit) override;
  absl::StatusOr<int> QuarantinedCount() override;
  absl::StatusOr<std::int64_t> SizeOf(absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::string>> List() override;

 private:
  absl::StatusOr<std::vector<std::byte>> ReadOnce(const std::string& key, absl::string_view sha256);

  const std::shared_ptr<ObjectStore> objects_;
  ServedAges ages_;  ///< of what is in quarantine
};

}  // namespace dcloc::server
