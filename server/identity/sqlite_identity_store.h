#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/base/sqlite.h"
#include "server/identity/identity_store.h"

namespace dcloc::server {

/// The identities in one SQLite file, in WAL mode. Several processes of one machine may have it
/// open. Calls take microseconds, as they find what they need by an index.
class SqliteIdentityStore final : public IdentityStore {
 public:
  /// Opens or creates it.
  static absl::StatusOr<std::unique_ptr<SqliteIdentityStore>> Open(
      const std::filesystem::path& path);

  absl::StatusOr<std::string> Create(Proof proof, const Principal& principal,
                                     std::optional<SystemTime> expire_time) override;
  absl::StatusOr<std::vector<IdentityRecord>> List(std::int64_t after, int limit) override;
  absl::Status Revoke(std::int64_t id) override;
  absl::StatusOr<Principal> FindToken(absl::string_view token) override;
  absl::StatusOr<Principal> FindCertificate(absl::string_view common_name) override;
  absl::StatusOr<bool> HasAny() override;

 private:
  explicit SqliteIdentityStore(SqliteDatabase database);
  absl::StatusOr<Principal> Find(const char* sql, absl::string_view key, absl::string_view what);

  std::mutex mutex_;
  SqliteDatabase database_;
  bool has_any_ = false;
};

}  // namespace dcloc::server
