#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "server/base/sqlite.h"
#include "server/maps/catalogue/build_queue.h"

namespace dcloc::server {

/// The queue of one process, in an SQLite file. What another process had taken is free: it has
/// ended, as it had this file.
class SqliteBuildQueue final : public BuildQueue {
 public:
  /// Makes the file, or brings that of an earlier program up to date. FailedPrecondition when a
  /// newer program wrote it.
  static absl::StatusOr<std::unique_ptr<SqliteBuildQueue>> Open(const std::filesystem::path& path);

  absl::Status Add(const BuildRow& row, int max_running) override;
  absl::StatusOr<BuildRow> Get(absl::string_view tenant, absl::string_view build_id) override;
  absl::StatusOr<std::vector<BuildRow>> List(absl::string_view tenant) override;
  absl::StatusOr<std::vector<std::string>> ListRunning() override;
  absl::StatusOr<BuildRow> Cancel(absl::string_view tenant, absl::string_view build_id) override;
  absl::StatusOr<std::optional<BuildRow>> Take(absl::string_view holder) override;
  absl::StatusOr<LeaseState> Renew(const BuildLease& lease, absl::string_view report) override;
  absl::StatusOr<bool> End(const BuildLease& lease, BuildState state,
                           absl::string_view report) override;
  absl::Status GiveBack(const BuildLease& lease) override;

 private:
  explicit SqliteBuildQueue(SqliteDatabase database) : database_(std::move(database)) {}

  template <typename Change>
  absl::Status InTransaction(const Change& change);
  // With the mutex held.
  absl::StatusOr<BuildRow> Find(absl::string_view tenant, absl::string_view build_id);

  std::mutex mutex_;
  SqliteDatabase database_;
};

}  // namespace dcloc::server
