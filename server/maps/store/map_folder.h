#pragma once

#include <filesystem>
#include <memory>

#include "server/maps/store/map_files.h"

namespace dcloc::server {

/// Map files in a local folder: `ab/ab12....dcmap`.
class MapFolder final : public MapFiles {
 public:
  /// Makes the folder if it is not there.
  static absl::StatusOr<std::unique_ptr<MapFolder>> Open(const std::filesystem::path& folder);

  /// `path` lies on the folder's file system.
  absl::Status Keep(const std::filesystem::path& path, absl::string_view sha256) override;
  absl::StatusOr<std::shared_ptr<const RadarMap>> Open(absl::string_view sha256) override;
  absl::Status Remove(absl::string_view sha256) override;
  absl::StatusOr<std::int64_t> SizeOf(absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::string>> List() override;

 private:
  explicit MapFolder(std::filesystem::path folder);
  std::filesystem::path PathOf(absl::string_view sha256) const;

  std::filesystem::path folder_;
};

}  // namespace dcloc::server
