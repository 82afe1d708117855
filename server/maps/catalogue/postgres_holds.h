#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/maps/catalogue/hold.h"
#include "server/postgres/postgres_database.h"

namespace dcloc::server {

/// The holds of this process, as all processes that share the database see them.
///
/// Each holder has a lease of 15 s by the database's clock, which the watch's thread renews every
/// 3 s, and a row for each version and file that it holds. When a process dies, its holds end with
/// its lease. Giving back only notes it; the watch's thread tells the database. Thread-safe.
class PostgresHolds {
 public:
  /// The catalogue's tables are there.
  explicit PostgresHolds(std::shared_ptr<PostgresDatabase> database);

  /// Gives back all that is left.
  ~PostgresHolds();

  /// As Catalogue::HoldVersion. While the database is away a version that `is_known` to have been
  /// there is held here, and in the database once it is back.
  absl::StatusOr<Hold> HoldVersion(absl::string_view map_name, std::int64_t version,
                                   absl::string_view holder, bool is_known);

  /// As Catalogue::HoldFile.
  absl::StatusOr<Hold> HoldFile(absl::string_view sha256, absl::string_view holder);

  /// Tells the database at once what has been given back, so that this process is not in its own
  /// way.
  absl::Status DeleteReleased();

  /// In a transaction: Unavailable when this process holds a file and its lease has ended
  /// meanwhile: another one may be removing the file.
  absl::Status CheckFileHold(PostgresConnection& connection, absl::string_view sha256) const;

 private:
  struct State;

  /// What the watch does: renews leases, and tells the database what it does not know.
  absl::Status Keep(PostgresConnection& connection, bool is_new);
  absl::Status RenewLeases(PostgresConnection& connection, bool is_new);
  absl::Status InsertAll(PostgresConnection& connection);

  const std::shared_ptr<PostgresDatabase> database_;
  const std::shared_ptr<State> state_;  ///< shared with the holds, which may outlive this
  std::chrono::steady_clock::time_point next_renewal_{};
  std::shared_ptr<void> task_;  ///< last: it uses the others
};

}  // namespace dcloc::server
