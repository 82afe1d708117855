#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/maps/catalogue/catalogue.h"
#include "server/maps/catalogue/postgres_holds.h"
#include "server/postgres/postgres_database.h"
#include "server/postgres/query_cache.h"

namespace dcloc::server {

/// The catalogue in a PostgreSQL database with PostGIS, for any number of servers.
///
/// `GetMap` and `GetVersion`, which each opening of a session asks, are answered from memory while
/// nothing has changed (QueryCache): a change by another server is seen within `kMaxChangeDelay`.
/// While the database is away they give what was known last, and a version that was known can be
/// held; all other calls are Unavailable.
class PostgresCatalogue final : public Catalogue {
 public:
  /// Makes the tables, or brings them up to date (PrepareTables).
  static absl::StatusOr<std::unique_ptr<PostgresCatalogue>> Open(
      std::shared_ptr<PostgresDatabase> database);

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
  explicit PostgresCatalogue(std::shared_ptr<PostgresDatabase> database);

  /// Runs `change(connection)` in a transaction; what was known before is then asked anew.
  template <typename Change>
  absl::Status WithChange(const Change& change);

  /// While the database is away: whether the version was there when it was asked for last.
  bool Knows(absl::string_view map_name, std::int64_t version);

  const std::shared_ptr<PostgresDatabase> database_;
  PostgresHolds holds_;
  QueryCache<std::string, MapRecord> maps_;
  QueryCache<std::pair<std::string, std::int64_t>, MapVersionRecord> versions_;
};

}  // namespace dcloc::server
