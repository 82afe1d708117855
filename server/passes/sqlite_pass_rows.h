#pragma once

#include <filesystem>
#include <memory>
#include <mutex>

#include "server/base/sqlite.h"
#include "server/passes/pass_rows.h"

namespace dcloc::server {

/// Those of one process, in an SQLite file.
class SqlitePassRows final : public PassRows {
 public:
  /// Makes the file, or brings that of an earlier program up to date. FailedPrecondition when a
  /// newer program wrote it.
  static absl::StatusOr<std::unique_ptr<SqlitePassRows>> Open(const std::filesystem::path& path);

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
  explicit SqlitePassRows(SqliteDatabase database) : database_(std::move(database)) {}

  template <typename Change>
  absl::Status InTransaction(const Change& change);

  std::mutex mutex_;
  SqliteDatabase database_;
};

}  // namespace dcloc::server
