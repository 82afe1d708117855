#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

struct sqlite3;
struct sqlite3_stmt;

namespace dcloc::server {

/// What a connection to an SQLite database may do.
enum class SqliteAccess {
  kCreate,  ///< read and write; the file is made, for its owner alone, if it is not there
  kRead,    ///< read only; NotFound when there is no file
};

/// How long a statement waits for another connection's lock, before it is Unavailable.
inline constexpr std::chrono::milliseconds kSqliteBusyTimeout{1000};

/// One connection to an SQLite database. Not thread-safe.
class SqliteDatabase {
 public:
  static absl::StatusOr<SqliteDatabase> Open(
      const std::filesystem::path& path, SqliteAccess access = SqliteAccess::kCreate,
      std::chrono::milliseconds busy_timeout = kSqliteBusyTimeout);

  /// Runs statements that give no rows.
  absl::Status Run(const char* sql);

  /// Rows that the last statement changed.
  int ChangedRowCount() const;

 private:
  friend class SqliteStatement;
  struct Close {
    void operator()(sqlite3* connection) const;
  };
  explicit SqliteDatabase(sqlite3* connection);
  absl::Status Error(int code, absl::string_view doing) const;

  std::unique_ptr<sqlite3, Close> connection_;
};

/// One statement: bind its parameters in order, then `Step` through its rows. A failure to prepare
/// or to bind is reported by the first `Step`.
class SqliteStatement {
 public:
  SqliteStatement(SqliteDatabase& database, const char* sql);

  SqliteStatement& Bind(std::int64_t value);
  SqliteStatement& Bind(double value);
  SqliteStatement& Bind(absl::string_view value);
  SqliteStatement& BindNull();

  /// True when there is a row, false after the last one.
  absl::StatusOr<bool> Step();

  /// For statements that give no rows.
  absl::Status Run();

  /// The next column of the row.
  std::int64_t NextInteger();
  double NextReal();
  std::string NextText();
  /// Whether the next column is null; does not move on.
  bool NextIsNull() const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  void Note(int code);

  SqliteDatabase& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  absl::Status status_;
  int parameter_ = 0;
  int column_ = 0;
};

/// Gives the statements within its life the same view of the database, whatever other connections
/// commit meanwhile. Waits for no writer.
class SqliteSnapshot {
 public:
  explicit SqliteSnapshot(SqliteDatabase& database)
      : database_(database), status_(database.Run("BEGIN")) {}
  ~SqliteSnapshot() {
    if (status_.ok()) database_.Run("COMMIT").IgnoreError();
  }
  SqliteSnapshot(const SqliteSnapshot&) = delete;
  SqliteSnapshot& operator=(const SqliteSnapshot&) = delete;

  /// Whether it began.
  const absl::Status& status() const { return status_; }

 private:
  SqliteDatabase& database_;
  absl::Status status_;
};

/// Rolls back at its end unless committed.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(SqliteDatabase& database);
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;

  /// Whether it began.
  const absl::Status& status() const { return status_; }
  absl::Status Commit();

 private:
  SqliteDatabase& database_;
  absl::Status status_;
  bool open_ = false;
};

}  // namespace dcloc::server
