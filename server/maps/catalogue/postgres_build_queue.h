#pragma once

#include <memory>

#include "server/maps/catalogue/build_queue.h"
#include "server/postgres/postgres_database.h"

namespace dcloc::server {

/// The queue of all servers on a PostgreSQL database. A lease lasts 15 s by the database's clock;
/// while the database was away nobody could renew one, so after its start all live for as long.
class PostgresBuildQueue final : public BuildQueue {
 public:
  /// Makes the table, or brings it up to date. Errors of `Migrate`.
  static absl::StatusOr<std::unique_ptr<PostgresBuildQueue>> Open(
      std::shared_ptr<PostgresDatabase> database);

  absl::Status Add(const BuildRow& row, int max_running) override;
  absl::StatusOr<BuildRow> Get(absl::string_view tenant, absl::string_view build_id) override;
  absl::StatusOr<std::vector<BuildRow>> List(absl::string_view tenant) override;
  absl::StatusOr<std::vector<std::string>> ListRunning() override;
  absl::StatusOr<BuildRow> Cancel(absl::string_view tenant, absl::string_view build_id) override;
  absl::StatusOr<std::optional<BuildRow>> Take(absl::string_view holder) override;
  absl::StatusOr<LeaseState> Renew(const BuildLease& lease, absl::string_view report) override;
  absl::StatusOr<bool> End(const BuildLease& lease, BuildState state,
                           absl::string_view report) override;
  absl::Status GiveBack(const BuildLease& lease) override;

 private:
  explicit PostgresBuildQueue(std::shared_ptr<PostgresDatabase> database)
      : database_(std::move(database)) {}

  const std::shared_ptr<PostgresDatabase> database_;
};

}  // namespace dcloc::server
