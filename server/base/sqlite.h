#pragma once

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

/// One connection to an SQLite database. Not thread-safe.
class SqliteDatabase {
 public:
  /// Opens or creates the file.
  static absl::StatusOr<SqliteDatabase> Open(const std::filesystem::path& path);

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
