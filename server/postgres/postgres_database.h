#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "server/postgres/postgres_options.h"
#include "server/postgres/postgres_pool.h"
#include "server/postgres/postgres_watch.h"

namespace dcloc::server {

/// One database, as all parts of a server share it.
struct PostgresDatabase {
  PostgresPool pool;
  std::unique_ptr<PostgresWatch> watch;

  /// Connects. Errors of `Validate` and `Migrate`; Unavailable when it is away.
  static absl::StatusOr<std::shared_ptr<PostgresDatabase>> Open(const PostgresOptions& options) {
    if (absl::Status status = Validate(options); !status.ok()) return status;
    std::shared_ptr<PostgresDatabase> database(new PostgresDatabase(options));
    absl::StatusOr<std::unique_ptr<PostgresWatch>> watch = PostgresWatch::Open(database->pool);
    if (!watch.ok()) return watch.status();
    database->watch = *std::move(watch);
    return database;
  }

 private:
  explicit PostgresDatabase(const PostgresOptions& options) : pool(options) {}
};

}  // namespace dcloc::server
