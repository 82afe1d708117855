#pragma once

#include <filesystem>
#include <memory>
#include <utility>

#include "server/maps/store/map_files.h"
#include "server/maps/store/served_ages.h"

namespace dcloc::server {

/// Map files in a local folder: `ab/ab12....dcmap`. Those in quarantine are in another folder of
/// the same file system, with how long they have been there beside it (`QUARANTINE.ages`).
class MapFolder final : public MapFiles {
 public:
  /// For a store that is only read: makes no folder.
  MapFolder(std::filesystem::path folder, std::filesystem::path quarantine)
      : folder_(std::move(folder)),
        quarantine_(std::move(quarantine)),
        ages_(quarantine_.string() + ".ages") {}

  /// Makes the folders if they are not there.
  static absl::StatusOr<std::unique_ptr<MapFolder>> Open(const std::filesystem::path& folder,
                                                         const std::filesystem::path& quarantine);

  /// `path` lies on the folder's file system.
  absl::Status Keep(const std::filesystem::path& path, absl::string_view sha256) override;
  absl::StatusOr<std::shared_ptr<const RadarMap>> Open(absl::string_view sha256) override;
  absl::Status Check(absl::string_view sha256, absl::FunctionRef<bool(std::size_t)> pace) override;
  absl::Status Remove(absl::string_view sha256) override;
  absl::Status Quarantine(absl::string_view sha256) override;
  absl::StatusOr<int> RemoveExpiredQuarantine(std::chrono::nanoseconds served,
                                              std::chrono::nanoseconds limit) override;
  absl::StatusOr<int> QuarantinedCount() override;
  absl::StatusOr<std::int64_t> SizeOf(absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::string>> List() override;

  /// Where a file is in such a folder.
  static std::filesystem::path PathIn(const std::filesystem::path& folder,
                                      absl::string_view sha256);

 private:
  std::filesystem::path PathOf(absl::string_view sha256) const { return PathIn(folder_, sha256); }

  const std::filesystem::path folder_;
  const std::filesystem::path quarantine_;
  ServedAges ages_;  ///< of what is in quarantine
};

}  // namespace dcloc::server
