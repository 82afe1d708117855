#pragma once

#include <chrono>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc::server {

/// How a database is reached, and how long it may take.
struct PostgresOptions {
  /// "postgresql://USER@HOST/DATABASE?sslmode=...", with any parameter of libpq but a password.
  std::string address;
  int max_connection_count = 4;  ///< for statements; one more waits for changes
  /// Of one statement, of a lock that it waits for, and of a wait for a free connection.
  std::chrono::milliseconds statement_timeout{2000};
  std::chrono::milliseconds connect_timeout{2000};
};

/// Whether a location of a catalogue is a database's address, and no file or folder.
bool IsPostgresAddress(absl::string_view location);

/// OK, or InvalidArgument naming what is wrong: no address; a password in it, which belongs into a
/// passfile or PGPASSWORD, as everyone on the machine reads a command line; another machine without
/// an explicit `sslmode`. Its message never has the address, which may hold a password.
absl::Status Validate(const PostgresOptions& options);

/// What of an address may stand in a log: "USER@HOST:PORT/DATABASE".
std::string ShownAddress(const std::string& address);

}  // namespace dcloc::server
