#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/postgres/postgres_database.h"
#include "server/replicas/replica_directory.h"

namespace dcloc::server {

/// A row for each server, with a lease by the database's clock, which the watch's thread renews
/// while the server lives. A row belongs to one server: another one that says it has the same
/// address gets it only after the lease has ended, and says in its log that it waits. Thread-safe.
class PostgresReplicaDirectory final : public ReplicaDirectory {
 public:
  /// As of holds: who has not renewed it for so long is taken for dead.
  static constexpr std::chrono::seconds kLease{15};

  /// Makes the table, and chooses the name by which this server owns its row. Errors of `Migrate`;
  /// Unavailable when the database is away.
  static absl::StatusOr<std::unique_ptr<PostgresReplicaDirectory>> Open(
      std::shared_ptr<PostgresDatabase> database);

  /// Takes this server's row away.
  ~PostgresReplicaDirectory() override;

  void Announce(const std::string& address) override;
  std::vector<std::string> Others() const override;

 private:
  PostgresReplicaDirectory(std::shared_ptr<PostgresDatabase> database, std::string owner);

  absl::Status Keep(PostgresConnection& connection, bool is_new);
  absl::Status RenewAndLook(PostgresConnection& connection, bool is_new);
  absl::Status Renew(PostgresConnection& connection);
  void NoteOwned(bool owned);
  absl::StatusOr<std::vector<std::string>> ReadOthers(PostgresConnection& connection) const;
  std::string own_address() const;

  const std::shared_ptr<PostgresDatabase> database_;
  const std::string owner_;  ///< this server's, of its row
  mutable std::mutex mutex_;
  std::string own_address_;  ///< empty before it is announced
  std::vector<std::string> others_;
  bool owned_ = true;                                     ///< the watch's thread's
  std::chrono::steady_clock::time_point next_renewal_{};  ///< the watch's thread's
  std::chrono::steady_clock::time_point next_look_{};     ///< the watch's thread's
  std::shared_ptr<void> task_;                            ///< last: it uses the others
};

}  // namespace dcloc::server
