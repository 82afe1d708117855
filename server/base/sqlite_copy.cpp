#include "server/base/sqlite_copy.h"

#include <sqlite3.h>

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/base/files.h"
#include "server/base/sqlite.h"

namespace dcloc::server {
namespace {

struct CloseConnection {
  void operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
};
using Connection = std::unique_ptr<sqlite3, CloseConnection>;

absl::Status CopyError(sqlite3* connection, int code) {
  const std::string message = absl::StrCat("database: copy: ", sqlite3_errmsg(connection));
  switch (code & 0xff) {
    case SQLITE_FULL:
      return absl::ResourceExhaustedError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return absl::UnavailableError(message);
    default:
      return absl::InternalError(message);
  }
}

absl::StatusOr<Connection> Connect(const std::filesystem::path& path, int flags) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &raw, flags, nullptr);
  Connection connection(raw);
  if (code != SQLITE_OK) return CopyError(raw, code);
  sqlite3_busy_timeout(raw, static_cast<int>(kSqliteBusyTimeout.count()));
  return connection;
}

/// By SQLite's online backup: all pages in one step, so that they are of one moment.
absl::Status CopyPages(const std::filesystem::path& from, const std::filesystem::path& to) {
  const absl::StatusOr<Connection> source = Connect(from, SQLITE_OPEN_READONLY);
  if (!source.ok()) return source.status();
  const absl::StatusOr<Connection> target = Connect(to, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  if (!target.ok()) return target.status();
  sqlite3_backup* backup = sqlite3_backup_init(target->get(), "main", source->get(), "main");
  if (backup == nullptr) return CopyError(target->get(), sqlite3_errcode(target->get()));
  sqlite3_backup_step(backup, -1);
  int code = sqlite3_backup_finish(backup);
  // One file alone, without a log beside it.
  if (code == SQLITE_OK) {
    code = sqlite3_exec(target->get(), "PRAGMA journal_mode = DELETE", nullptr, nullptr, nullptr);
  }
  return code == SQLITE_OK ? absl::OkStatus() : CopyError(target->get(), code);
}

}  // namespace

absl::Status CopyDatabase(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (!IsThere(from)) {
    return absl::NotFoundError(absl::StrCat(from.string(), ": there is no such file"));
  }
  if (const auto size = FileSize(from); !size.ok())
    return size.status();  // not of a pipe, which has no end
  const std::filesystem::path partial = to.string() + ".partial";
  absl::Status status = RemoveFile(partial);
  if (status.ok()) status = CopyPages(from, partial);
  if (status.ok()) status = CheckDatabase(partial);
  if (status.ok()) status = SyncFile(partial);
  if (status.ok()) status = MoveFile(partial, to);
  if (status.ok()) return SyncFolder(to.parent_path());
  RemoveFile(partial).IgnoreError();
  return status;
}

absl::Status CheckDatabase(const std::filesystem::path& path) {
  absl::StatusOr<SqliteDatabase> database = SqliteDatabase::Open(path, SqliteAccess::kRead);
  if (!database.ok()) return database.status();
  SqliteStatement query(*database, "PRAGMA integrity_check(1)");
  const absl::StatusOr<bool> row = query.Step();
  if (!row.ok()) return row.status();
  const std::string result = query.NextText();
  return result == "ok" ? absl::OkStatus()
                        : absl::DataLossError(absl::StrCat("database: ", result));
}

}  // namespace dcloc::server
