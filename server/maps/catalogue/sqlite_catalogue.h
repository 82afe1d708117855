#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <utility>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/catalogue.h"
#include "server/maps/catalogue/local_holds.h"

namespace dcloc::server {

/// The catalogue in one SQLite file, in WAL mode, for one process. The caller makes sure that no
/// other process changes it. Holds therefore lie in memory (LocalHolds). Changes and reads have a
/// connection each, so that who reads never waits for who writes.
class SqliteCatalogue final : public Catalogue {
 public:
  /// Opens or creates it. Errors of `PrepareSchema`.
  static absl::StatusOr<std::unique_ptr<SqliteCatalogue>> Open(const std::filesystem::path& path);

  /// Opens it beside the process that has it: changes fail. NotFound; FailedPrecondition when it is
  /// not of this program's version.
  static absl::StatusOr<std::unique_ptr<SqliteCatalogue>> OpenToRead(
      const std::filesystem::path& path);

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
  absl::Status AddLooseFile(absl::string_view sha256) override;
  absl::Status RemoveLooseFile(absl::string_view sha256) override;
  absl::StatusOr<std::vector<std::string>> ListLooseFiles() override;
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
  SqliteCatalogue(SqliteDatabase writer, SqliteDatabase reader);

  /// Runs `read(connection)` in a snapshot.
  template <typename Read>
  auto WithReader(const Read& read) -> decltype(read(std::declval<SqliteDatabase&>()));
  /// Runs `change(connection)` in a transaction, which is committed when it returns OK.
  template <typename Change>
  absl::Status WithWriter(const Change& change);

  std::mutex write_mutex_;
  SqliteDatabase writer_;
  std::mutex read_mutex_;
  SqliteDatabase reader_;  ///< closed first, so that the other one can tidy up
  LocalHolds holds_;
};

}  // namespace dcloc::server
