#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/identity/identity_store.h"
#include "server/postgres/postgres_database.h"
#include "server/postgres/query_cache.h"

namespace dcloc::server {

/// The identities in a PostgreSQL database, for any number of servers. What was found is remembered
/// while nothing has changed, so that a call asks the database only once for each identity. A
/// change by another server is seen within `kMaxChangeDelay`. While the database is away, tokens
/// and certificates that were known to be good within `max_away` are good.
class PostgresIdentityStore final : public IdentityStore {
 public:
  /// Makes the table, or brings it up to date.
  static absl::StatusOr<std::unique_ptr<PostgresIdentityStore>> Open(
      std::shared_ptr<PostgresDatabase> database,
      std::chrono::nanoseconds max_away = std::chrono::minutes(15));

  absl::StatusOr<std::string> Create(Proof proof, const Principal& principal,
                                     std::optional<SystemTime> expire_time) override;
  absl::StatusOr<std::vector<IdentityRecord>> List(std::int64_t after, int limit) override;
  absl::Status Revoke(std::int64_t id) override;
  absl::StatusOr<Principal> FindToken(absl::string_view token) override;
  absl::StatusOr<Principal> FindCertificate(absl::string_view common_name) override;
  absl::StatusOr<bool> HasAny() override;

 private:
  PostgresIdentityStore(std::shared_ptr<PostgresDatabase> database,
                        std::chrono::nanoseconds max_away);
  absl::StatusOr<Principal> Find(const std::string& where, const std::string& key,
                                 const std::string& what);

  const std::shared_ptr<PostgresDatabase> database_;
  QueryCache<std::string, IdentityRecord> known_;  ///< by the condition and its key
  QueryCache<std::string, bool> any_;              ///< of one question
};

}  // namespace dcloc::server
