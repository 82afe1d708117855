#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/postgres/postgres_options.h"

struct pg_conn;
struct pg_result;

namespace dcloc::server {

/// The values of a statement's `$1`, `$2`, ..., bound in order.
class PostgresValues {
 public:
  PostgresValues& Bind(std::int64_t value);
  PostgresValues& Bind(double value);  ///< exactly
  PostgresValues& Bind(bool value);
  PostgresValues& Bind(absl::string_view value);
  PostgresValues& BindNull();

  /// For a column of bytes, which unlike a text may hold any.
  PostgresValues& BindBytes(absl::string_view bytes);

  /// For an array, `$1::float8[]`.
  PostgresValues& BindArray(const std::vector<std::optional<double>>& values);

 private:
  friend class PostgresConnection;
  std::vector<std::optional<std::string>> texts_;
  bool has_nul_ = false;  ///< a text with a NUL, which the database would cut off
};

/// The rows of a statement, one after the other, and the columns of each in order.
class PostgresRows {
 public:
  /// To the next row, at first to the first one; false after the last one.
  bool Next();

  std::int64_t NextInteger();
  double NextReal();
  bool NextBool();
  std::string NextText();
  std::string NextBytes();
  /// Whether the next column is null; does not move on.
  bool NextIsNull() const;

  /// Rows that the statement changed, or gives.
  std::int64_t count() const;

 private:
  friend class PostgresConnection;
  struct Clear {
    void operator()(pg_result* result) const;
  };
  explicit PostgresRows(pg_result* result) : result_(result) {}
  const char* NextValue();

  std::unique_ptr<pg_result, Clear> result_;
  int row_ = -1;
  int column_ = 0;
};

/// One connection to a PostgreSQL database. Not thread-safe.
///
/// Errors: Unavailable when the database is away, busy, holds a lock or took too long; then the
/// statement had no effect, unless it was a COMMIT. ResourceExhausted when its disk or memory is
/// full, DataLoss when its files are damaged, AlreadyExists when a unique key is taken,
/// InvalidArgument when a text has a NUL byte, else Internal. No message names the address.
class PostgresConnection {
 public:
  using Clock = std::chrono::steady_clock;

  static absl::StatusOr<std::unique_ptr<PostgresConnection>> Open(const PostgresOptions& options);
  ~PostgresConnection();
  PostgresConnection(const PostgresConnection&) = delete;
  PostgresConnection& operator=(const PostgresConnection&) = delete;

  /// One statement.
  absl::StatusOr<PostgresRows> Query(const char* sql, const PostgresValues& values = {});

  /// A statement that reads a whole table. A million rows may take longer than what a caller waits
  /// for, so it has a bound of its own, `kWholeTableTimeout`.
  absl::StatusOr<PostgresRows> QueryWhole(const std::string& sql);
  static constexpr std::chrono::milliseconds kWholeTableTimeout{60'000};

  /// Several statements without values; the rows of the last one. Takes `timeout` at most.
  absl::StatusOr<PostgresRows> RunAll(const std::string& sql, std::chrono::milliseconds timeout);

  /// Whether it is of use: it was not lost, and nothing is left of a transaction.
  bool IsIdle() const;

  /// Takes in what the database has sent by itself; whether there was a notification (NOTIFY).
  /// Unavailable when the connection is lost.
  absl::StatusOr<bool> TakeNotifications();

  /// To wait on; readable when something came or the connection was lost.
  int descriptor() const;

 private:
  struct Finish {
    void operator()(pg_conn* connection) const;
  };
  PostgresConnection(pg_conn* connection, std::chrono::milliseconds timeout);

  absl::Status Connect(Clock::time_point deadline);
  absl::Status SetUp();
  absl::Status SetStatementTimeout(std::chrono::milliseconds timeout);
  /// Waits until the socket is ready, for what `poll` calls `events`.
  absl::Status Wait(short events, Clock::time_point deadline);
  absl::StatusOr<PostgresRows> Receive(Clock::time_point deadline);
  absl::Status Flush(Clock::time_point deadline);
  absl::Status Lost(absl::string_view reason);

  std::unique_ptr<pg_conn, Finish> connection_;
  const std::chrono::milliseconds timeout_;
  bool lost_ = false;
};

}  // namespace dcloc::server
