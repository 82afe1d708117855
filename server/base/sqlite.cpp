#include "server/base/sqlite.h"

#include <sqlite3.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/files.h"

namespace dcloc::server {
namespace {

absl::StatusCode CodeOf(int sqlite_code) {
  switch (sqlite_code & 0xff) {
    case SQLITE_FULL:
    case SQLITE_NOMEM:
      return absl::StatusCode::kResourceExhausted;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::StatusCode::kDataLoss;
    case SQLITE_CONSTRAINT:
      return absl::StatusCode::kAlreadyExists;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return absl::StatusCode::kUnavailable;
    default:
      return absl::StatusCode::kInternal;
  }
}

}  // namespace

void SqliteDatabase::Close::operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }

SqliteDatabase::SqliteDatabase(sqlite3* connection) : connection_(connection) {}

absl::StatusOr<SqliteDatabase> SqliteDatabase::Open(const std::filesystem::path& path,
                                                    SqliteAccess access,
                                                    std::chrono::milliseconds busy_timeout) {
  const bool creates = access == SqliteAccess::kCreate;
  // SQLite would wait for somebody to write to a pipe.
  const absl::StatusOr<std::int64_t> size = FileSize(path);
  if (!size.ok()) return size.status();
  if (creates) {
    // SQLite itself would let everyone read it. Its further files take over this one's mode.
    if (absl::Status status = OpenOrCreate(path).status(); !status.ok()) return status;
  } else if (!IsThere(path)) {
    return absl::NotFoundError(absl::StrCat(path.string(), ": there is no such file"));
  }
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &connection,
                                   creates ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY, nullptr);
  // Even a failed open gives a connection, which holds the message.
  SqliteDatabase database(connection);
  if (code != SQLITE_OK) return database.Error(code, path.string());
  sqlite3_extended_result_codes(connection, 1);
  sqlite3_busy_timeout(connection, static_cast<int>(busy_timeout.count()));
  return database;
}

absl::Status SqliteDatabase::Error(int code, absl::string_view doing) const {
  absl::Status status(
      CodeOf(code), absl::StrFormat("database: %s: %s", doing, sqlite3_errmsg(connection_.get())));
  const char* path = sqlite3_db_filename(connection_.get(), "main");
  return path == nullptr ? status : AboutFile(std::move(status), path);
}

absl::Status SqliteDatabase::Run(const char* sql) {
  const int code = sqlite3_exec(connection_.get(), sql, nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : Error(code, sql);
}

int SqliteDatabase::ChangedRowCount() const { return sqlite3_changes(connection_.get()); }

void SqliteStatement::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

SqliteStatement::SqliteStatement(SqliteDatabase& database, const char* sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  Note(sqlite3_prepare_v2(database.connection_.get(), sql, -1, &statement, nullptr));
  statement_.reset(statement);
}

void SqliteStatement::Note(int code) {
  if (code != SQLITE_OK && status_.ok()) status_ = database_.Error(code, "statement");
}

SqliteStatement& SqliteStatement::Bind(std::int64_t value) {
  if (status_.ok()) Note(sqlite3_bind_int64(statement_.get(), ++parameter_, value));
  return *this;
}

SqliteStatement& SqliteStatement::Bind(double value) {
  if (status_.ok()) Note(sqlite3_bind_double(statement_.get(), ++parameter_, value));
  return *this;
}

SqliteStatement& SqliteStatement::Bind(absl::string_view value) {
  if (status_.ok()) {
    // An empty view may have no address, which SQLite would take for null.
    Note(sqlite3_bind_text(statement_.get(), ++parameter_, value.empty() ? "" : value.data(),
                           static_cast<int>(value.size()), SQLITE_TRANSIENT));
  }
  return *this;
}

SqliteStatement& SqliteStatement::BindNull() {
  if (status_.ok()) Note(sqlite3_bind_null(statement_.get(), ++parameter_));
  return *this;
}

absl::StatusOr<bool> SqliteStatement::Step() {
  if (!status_.ok()) return status_;
  column_ = 0;
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  Note(code);
  return status_;
}

absl::Status SqliteStatement::Run() { return Step().status(); }

std::int64_t SqliteStatement::NextInteger() {
  return sqlite3_column_int64(statement_.get(), column_++);
}

double SqliteStatement::NextReal() { return sqlite3_column_double(statement_.get(), column_++); }

std::string SqliteStatement::NextText() {
  const int column = column_++;
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return text == nullptr ? std::string() : std::string(text, static_cast<std::size_t>(size));
}

bool SqliteStatement::NextIsNull() const {
  return sqlite3_column_type(statement_.get(), column_) == SQLITE_NULL;
}

SqliteTransaction::SqliteTransaction(SqliteDatabase& database)
    : database_(database), status_(database.Run("BEGIN IMMEDIATE")), open_(status_.ok()) {}

SqliteTransaction::~SqliteTransaction() {
  if (open_) database_.Run("ROLLBACK").IgnoreError();
}

absl::Status SqliteTransaction::Commit() {
  absl::Status status = database_.Run("COMMIT");
  if (status.ok()) open_ = false;
  return status;
}

}  // namespace dcloc::server
