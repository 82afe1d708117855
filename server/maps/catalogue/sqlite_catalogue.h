#pragma once

#include <filesystem>
#include <memory>
#include <mutex>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/catalogue/local_holds.h"

namespace dcloc::server {

/// The catalogue in one SQLite file, in WAL mode, for one process. The caller makes sure that no
/// other process opens it. Holds therefore lie in memory (LocalHolds).
class SqliteCatalogue final : public Catalogue {
 public:
  /// Opens or creates it. FailedPrecondition when a newer program wrote it.
  static absl::StatusOr<std::unique_ptr<SqliteCatalogue>> Open(const std::filesystem::path& path);

  absl::StatusOr<std::vector<MapRecord>> ListMaps(absl::string_view prefix,
                                                  absl::string_view after_name, int limit) override;
  absl::StatusOr<std::int64_t> SizeOfMaps(absl::string_view prefix) override;
  absl::StatusOr<MapRecord> GetMap(absl::string_view map_name) override;
  absl::StatusOr<std::vector<MapVersionRecord>> ListVersions(absl::string_view map_name,
                                                             std::int64_t below_version,
                                                             int limit) override;
  absl::StatusOr<MapVersionRecord> GetVersion(absl::string_view map_name,
                                              std::int64_t version) override;
  absl::StatusOr<MapVersionRecord> AddVersion(absl::string_view map_name, absl::string_view sha256,
                                              const MapInfo& info,
                                              const std::vector<CoverageBox>& coverage) override;
  absl::Status Activate(absl::string_view map_name, std::int64_t version) override;
  absl::Status SetCanary(absl::string_view map_name, std::int64_t version, double share) override;
  absl::StatusOr<Hold> HoldVersion(absl::string_view map_name, std::int64_t version,
                                   absl::string_view holder) override;
  absl::StatusOr<Hold> HoldFile(absl::string_view sha256, absl::string_view holder) override;
  absl::Status DeleteVersion(absl::string_view map_name, std::int64_t version) override;
  absl::Status DeleteMap(absl::string_view map_name) override;
  absl::StatusOr<bool> HasFile(absl::string_view sha256) override;
  absl::StatusOr<std::int64_t> SizeOfFile(absl::string_view prefix,
                                          absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::pair<std::string, std::int64_t>>> ListFiles() override;
  absl::StatusOr<std::vector<MapVersionRecord>> ListUncovered() override;
  absl::Status AddCoverage(absl::string_view map_name, std::int64_t version,
                           const std::vector<CoverageBox>& coverage) override;
  absl::StatusOr<std::vector<CoverageRecord>> FindCoverage(absl::string_view map_name,
                                                           const Eigen::Vector2d& p_map,
                                                           double radius_m) override;
  absl::StatusOr<std::vector<CoverageRecord>> FindCoverage(absl::string_view prefix,
                                                           const GeodeticPosition& position,
                                                           double radius_m, int limit) override;

 private:
  explicit SqliteCatalogue(SqliteDatabase database);

  // All with the mutex held.
  absl::StatusOr<MapRecord> FindMap(absl::string_view map_name);
  absl::StatusOr<MapVersionRecord> FindVersion(absl::string_view map_name, std::int64_t version);
  /// The version that has this file, or 0.
  absl::StatusOr<std::int64_t> VersionOfFile(absl::string_view map_name, absl::string_view sha256);
  /// Takes the map's next number, and creates the map if it is new.
  absl::StatusOr<std::int64_t> TakeNumber(absl::string_view map_name);

  /// Also held while a version gets a hold or is deleted, so that neither comes between.
  std::mutex mutex_;
  SqliteDatabase database_;
  LocalHolds holds_;
};

}  // namespace dcloc::server
