#pragma once

#include <memory>

#include "server/passes/pass_rows.h"
#include "server/postgres/postgres_database.h"

namespace dcloc::server {

/// Those of all servers on a PostgreSQL database.
class PostgresPassRows final : public PassRows {
 public:
  /// Makes the tables, or brings them up to date. Errors of `Migrate`.
  static absl::StatusOr<std::unique_ptr<PostgresPassRows>> Open(
      std::shared_ptr<PostgresDatabase> database);

  absl::Status GiveConsent(absl::string_view tenant, const ConsentRow& consent) override;
  absl::StatusOr<std::vector<std::string>> WithdrawConsent(absl::string_view tenant,
                                                           const ConsentRow& consent,
                                                           absl::string_view pseudonym) override;
  absl::StatusOr<bool> MayKeep(absl::string_view tenant, absl::string_view map_name,
                               absl::string_view identity_name) override;
  absl::StatusOr<std::vector<ConsentRow>> ListConsents(absl::string_view tenant,
                                                       std::int64_t offset, int limit) override;
  absl::Status Add(const PassRow& row, absl::string_view identity_name,
                   const PassQuota& quota) override;
  absl::StatusOr<std::vector<PassRow>> List(absl::string_view tenant, absl::string_view map_name,
                                            std::int64_t below, int limit) override;
  absl::StatusOr<std::vector<std::string>> RemoveExpired(SystemTime now) override;
  absl::StatusOr<std::vector<std::string>> ListIds() override;
  absl::StatusOr<std::int64_t> TotalBytes() override;

 private:
  explicit PostgresPassRows(std::shared_ptr<PostgresDatabase> database)
      : database_(std::move(database)) {}

  const std::shared_ptr<PostgresDatabase> database_;
};

}  // namespace dcloc::server
