#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "server/maps/store/map_files.h"
#include "server/maps/store/served_ages.h"

namespace dcloc::server {

/// Map files in a folder: `ab/ab12....dcmap`. Those in quarantine are in another folder of the same
/// file system, with how long they have been there beside it (`QUARANTINE.ages`).
///
/// Several processes may share the folder. Then each keeps files by copying them, under a name of
/// its own until they are whole. Who keeps, removes or sets aside a file holds it in the catalogue
/// (Catalogue::HoldFile), and one process at a time calls `RemoveExpiredQuarantine`.
class MapFolder final : public MapFiles {
 public:
  /// For a store that is only read: makes no folder. `copier` names this process among those that
  /// share the folder; empty: files come from the same file system, and are moved.
  MapFolder(std::filesystem::path folder, std::filesystem::path quarantine, std::string copier = "")
      : folder_(std::move(folder)),
        quarantine_(std::move(quarantine)),
        copier_(std::move(copier)),
        ages_(quarantine_.string() + ".ages") {}

  /// Makes the folders if they are not there.
  static absl::StatusOr<std::unique_ptr<MapFolder>> Open(const std::filesystem::path& folder,
                                                         const std::filesystem::path& quarantine,
                                                         const std::string& copier = "");

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

  /// Where a file is in such a folder.
  static std::filesystem::path PathIn(const std::filesystem::path& folder,
                                      absl::string_view sha256);

  /// The hash of the file that is at such a place; empty when it is no place of a map file.
  static std::string HashOf(const std::filesystem::path& path);

 private:
  std::filesystem::path PathOf(absl::string_view sha256) const { return PathIn(folder_, sha256); }

  /// Copies a file to its place, where it is whole or not at all.
  absl::Status Copy(const std::filesystem::path& path, absl::string_view sha256) const;
  /// Removes what copiers that died have left of a file.
  absl::Status RemoveParts(absl::string_view sha256) const;

  const std::filesystem::path folder_;
  const std::filesystem::path quarantine_;
  const std::string copier_;
  ServedAges ages_;  ///< of what is in quarantine
};

}  // namespace dcloc::server
