#include "server/maps/catalogue/sqlite_build_queue.h"

#include <utility>

#include "server/base/sqlite_steps.h"
#include "server/maps/catalogue/build_columns.h"
#include "server/maps/catalogue/sqlite_rows.h"

namespace dcloc::server {
namespace {

constexpr const char* kSqliteBuildSteps[] = {R"(
CREATE TABLE map_build (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  build_id TEXT NOT NULL UNIQUE,
  tenant TEXT NOT NULL,
  map_name TEXT NOT NULL,
  state INTEGER NOT NULL,
  create_time_ns INTEGER NOT NULL,
  input_sha256 TEXT NOT NULL,
  report TEXT NOT NULL,
  attempt_count INTEGER NOT NULL DEFAULT 0,
  cancelled INTEGER NOT NULL DEFAULT 0,
  holder TEXT NOT NULL DEFAULT ''
) STRICT;
CREATE INDEX map_build_tenant ON map_build (tenant, number);
)"};

BuildRow ReadBuild(SqliteStatement& row) {
  return NextBuild(row, [](SqliteStatement& report) { return report.NextText(); });
}

std::string ReadBuildId(SqliteStatement& row) { return row.NextText(); }

absl::StatusOr<std::int64_t> RunningCount(SqliteDatabase& database, absl::string_view tenant) {
  SqliteStatement query(database, "SELECT COUNT(*) FROM map_build WHERE tenant = ? AND state = 0");
  const absl::StatusOr<bool> row = query.Bind(tenant).Step();
  if (!row.ok()) return row.status();
  return query.NextInteger();
}

absl::Status ForgetOldest(SqliteDatabase& database, absl::string_view tenant) {
  SqliteStatement erase(database,
                        "DELETE FROM map_build WHERE number IN (SELECT number FROM map_build"
                        " WHERE tenant = ? AND state <> 0 ORDER BY number DESC LIMIT -1 OFFSET ?)");
  return erase.Bind(tenant).Bind(std::int64_t{BuildQueue::kMaxEnded}).Run();
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteBuildQueue>> SqliteBuildQueue::Open(
    const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path);
  if (!database.ok()) return database.status();
  if (absl::Status status = TakeSteps(*database, "builds", kSqliteBuildSteps); !status.ok())
    return status;
  return std::unique_ptr<SqliteBuildQueue>(new SqliteBuildQueue(*std::move(database)));
}

template <typename Change>
absl::Status SqliteBuildQueue::InTransaction(const Change& change) {
  const std::lock_guard lock(mutex_);
  SqliteTransaction transaction(database_);
  absl::Status status = transaction.status();
  if (status.ok()) status = change();
  return status.ok() ? transaction.Commit() : status;
}

absl::Status SqliteBuildQueue::Add(const BuildRow& row, int max_running) {
  return InTransaction([&]() -> absl::Status {
    const absl::StatusOr<std::int64_t> running = RunningCount(database_, row.tenant);
    if (!running.ok()) return running.status();
    if (*running >= max_running) return TooManyBuilds(max_running);
    SqliteStatement insert(database_,
                           "INSERT INTO map_build (build_id, tenant, map_name, state,"
                           " create_time_ns, input_sha256, report) VALUES (?,?,?,?,?,?,?)");
    insert.Bind(row.build_id).Bind(row.tenant).Bind(row.map_name).Bind(NumberOf(row.state));
    insert.Bind(std::int64_t{row.create_time.time_since_epoch().count()});
    insert.Bind(row.input_sha256).Bind(row.report);
    absl::Status status = insert.Run();
    return status.ok() ? ForgetOldest(database_, row.tenant) : status;
  });
}

absl::StatusOr<BuildRow> SqliteBuildQueue::Find(absl::string_view tenant,
                                                absl::string_view build_id) {
  SqliteStatement query(database_, SelectBuilds("WHERE tenant = ? AND build_id = ?").c_str());
  const absl::StatusOr<bool> row = query.Bind(tenant).Bind(build_id).Step();
  if (!row.ok()) return row.status();
  if (!*row) return NoSuchBuild(build_id);
  return ReadBuild(query);
}

absl::StatusOr<BuildRow> SqliteBuildQueue::Get(absl::string_view tenant,
                                               absl::string_view build_id) {
  const std::lock_guard lock(mutex_);
  return Find(tenant, build_id);
}

absl::StatusOr<std::vector<BuildRow>> SqliteBuildQueue::List(absl::string_view tenant) {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, SelectBuilds("WHERE tenant = ? ORDER BY number DESC").c_str());
  query.Bind(tenant);
  return ReadAll(query, ReadBuild);
}

absl::StatusOr<std::vector<std::string>> SqliteBuildQueue::ListRunning() {
  const std::lock_guard lock(mutex_);
  SqliteStatement query(database_, "SELECT build_id FROM map_build WHERE state = 0");
  return ReadAll(query, ReadBuildId);
}

absl::StatusOr<BuildRow> SqliteBuildQueue::Cancel(absl::string_view tenant,
                                                  absl::string_view build_id) {
  const std::lock_guard lock(mutex_);
  SqliteStatement update(database_,
                         "UPDATE map_build SET cancelled = 1,"
                         " state = CASE WHEN holder = '' THEN ?1 ELSE state END"
                         " WHERE tenant = ?2 AND build_id = ?3 AND state = 0");
  const absl::Status status =
      update.Bind(NumberOf(BuildState::kCancelled)).Bind(tenant).Bind(build_id).Run();
  if (!status.ok()) return status;
  return Find(tenant, build_id);
}

absl::StatusOr<std::optional<BuildRow>> SqliteBuildQueue::Take(absl::string_view holder) {
  std::optional<BuildRow> taken;
  absl::Status status = InTransaction([&]() -> absl::Status {
    SqliteStatement end(database_,
                        "UPDATE map_build SET state = ? WHERE state = 0 AND cancelled = 1");
    absl::Status ended = end.Bind(NumberOf(BuildState::kCancelled)).Run();
    if (!ended.ok()) return ended;
    SqliteStatement query(database_,
                          SelectBuilds("WHERE state = 0 ORDER BY number LIMIT 1").c_str());
    const absl::StatusOr<bool> row = query.Step();
    if (!row.ok() || !*row) return row.status();
    taken = ReadBuild(query);
    ++taken->attempt_count;
    SqliteStatement take(database_,
                         "UPDATE map_build SET holder = ?, attempt_count = attempt_count + 1"
                         " WHERE build_id = ?");
    return take.Bind(holder).Bind(taken->build_id).Run();
  });
  if (!status.ok()) return status;
  return taken;
}

absl::StatusOr<LeaseState> SqliteBuildQueue::Renew(const BuildLease& lease,
                                                   absl::string_view report) {
  const std::lock_guard lock(mutex_);
  SqliteStatement update(database_,
                         "UPDATE map_build SET report = ? WHERE build_id = ? AND holder = ?"
                         " AND attempt_count = ? AND state = 0 RETURNING cancelled");
  const absl::StatusOr<bool> row =
      update.Bind(report).Bind(lease.build_id).Bind(lease.holder).Bind(lease.attempt).Step();
  if (!row.ok()) return row.status();
  if (!*row) return LeaseState::kLost;
  return update.NextInteger() != 0 ? LeaseState::kCancelled : LeaseState::kHeld;
}

absl::StatusOr<bool> SqliteBuildQueue::End(const BuildLease& lease, BuildState state,
                                           absl::string_view report) {
  const std::lock_guard lock(mutex_);
  SqliteStatement update(database_,
                         "UPDATE map_build SET state = ?, report = ? WHERE build_id = ?"
                         " AND holder = ? AND attempt_count = ? AND state = 0");
  absl::Status status = update.Bind(NumberOf(state))
                            .Bind(report)
                            .Bind(lease.build_id)
                            .Bind(lease.holder)
                            .Bind(lease.attempt)
                            .Run();
  if (!status.ok()) return status;
  return database_.ChangedRowCount() > 0;
}

absl::Status SqliteBuildQueue::GiveBack(const BuildLease& lease) {
  const std::lock_guard lock(mutex_);
  SqliteStatement update(database_,
                         "UPDATE map_build SET holder = '', attempt_count = attempt_count - 1"
                         " WHERE build_id = ? AND holder = ? AND attempt_count = ? AND state = 0");
  return update.Bind(lease.build_id).Bind(lease.holder).Bind(lease.attempt).Run();
}

}  // namespace dcloc::server
