#pragma once

#include <span>

#include "absl/status/status.h"
#include "server/postgres/postgres_connection.h"

namespace dcloc::server {

/// The tables of one part of the program, as a list of steps that is only ever added to. Step k
/// brings the schema `dcloc` of a database from version k - 1 of the part to k.
struct PostgresMigrations {
  const char* part;
  std::span<const char* const> steps;
};

/// Brings a database to the last step, in one transaction; of several programs that start at once
/// one does it and the others wait. FailedPrecondition when a newer program has made more steps:
/// then nothing is changed.
absl::Status Migrate(PostgresConnection& connection, const PostgresMigrations& migrations);

}  // namespace dcloc::server
