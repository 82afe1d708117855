#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/postgres/postgres_connection.h"

/// Rows of holders and holds. All errors are the database's but for those named.
namespace dcloc::server {

struct VersionHoldKey {
  std::string map_name;
  std::int64_t version = 0;
  std::string holder;
  auto operator<=>(const VersionHoldKey&) const = default;
};

/// Whether its lease had not been removed, as that of a dead one.
absl::StatusOr<bool> RenewLease(PostgresConnection& connection, absl::string_view holder);

/// With all of its holds.
absl::Status DeleteHolder(PostgresConnection& connection, absl::string_view holder);

/// Those whose leases have ended for some time. Who was away for a moment finds its holds again.
absl::Status DeleteDeadHolders(PostgresConnection& connection);

/// In a transaction. NotFound: no such map or version; Unavailable: it is being deleted.
absl::Status InsertVersionHold(PostgresConnection& connection, const VersionHoldKey& key);

/// For a hold that there was; whether the version is still there.
absl::StatusOr<bool> InsertVersionHoldAgain(PostgresConnection& connection,
                                            const VersionHoldKey& key);

absl::Status DeleteVersionHold(PostgresConnection& connection, const VersionHoldKey& key);

/// Whether a holder that lives has a version of a map: the newest such version, or 0. `version` 0:
/// any version.
absl::StatusOr<std::int64_t> NewestHeldVersion(PostgresConnection& connection,
                                               absl::string_view map_name, std::int64_t version);

/// In a transaction. A token that no other hold ever has. Unavailable when a holder that lives has
/// the file; `held_here`: that may be this one, otherwise what it has is left over.
absl::StatusOr<std::int64_t> InsertFileHold(PostgresConnection& connection,
                                            absl::string_view sha256, absl::string_view holder,
                                            bool held_here);

absl::Status DeleteFileHold(PostgresConnection& connection, std::int64_t token);

/// In a transaction, until whose end the hold stays. Unavailable when another one has the file.
absl::Status CheckFileToken(PostgresConnection& connection, absl::string_view sha256,
                            std::int64_t token);

}  // namespace dcloc::server
