#include "server/postgres/postgres_connection.h"

#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "server/postgres/postgres_error.h"

namespace dcloc::server {
namespace {

/// The database gives up a statement a little earlier than we do. So we give up only on one that
/// does not answer at all.
constexpr std::chrono::milliseconds kAnswerGrace(500);

/// The shortest text from which the same double is read.
std::string TextOf(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

/// Without this a notice would go to standard error.
void IgnoreNotice(void* /*unused*/, const PGresult* /*notice*/) {}

}  // namespace

PostgresValues& PostgresValues::Bind(std::int64_t value) {
  texts_.emplace_back(absl::StrCat(value));
  return *this;
}

PostgresValues& PostgresValues::Bind(double value) {
  texts_.emplace_back(TextOf(value));
  return *this;
}

PostgresValues& PostgresValues::Bind(bool value) {
  texts_.emplace_back(value ? "t" : "f");
  return *this;
}

PostgresValues& PostgresValues::Bind(absl::string_view value) {
  has_nul_ = has_nul_ || absl::StrContains(value, '\0');
  texts_.emplace_back(std::string(value));
  return *this;
}

PostgresValues& PostgresValues::BindNull() {
  texts_.emplace_back(std::nullopt);
  return *this;
}

PostgresValues& PostgresValues::BindBytes(absl::string_view bytes) {
  texts_.emplace_back(absl::StrCat("\\x", absl::BytesToHexString(bytes)));
  return *this;
}

PostgresValues& PostgresValues::BindArray(const std::vector<std::optional<double>>& values) {
  const auto append = [](std::string* out, const std::optional<double>& value) {
    out->append(value ? TextOf(*value) : "NULL");
  };
  texts_.emplace_back(absl::StrCat("{", absl::StrJoin(values, ",", append), "}"));
  return *this;
}

void PostgresRows::Clear::operator()(pg_result* result) const { PQclear(result); }

bool PostgresRows::Next() {
  column_ = 0;
  return ++row_ < PQntuples(result_.get());
}

const char* PostgresRows::NextValue() { return PQgetvalue(result_.get(), row_, column_++); }

std::int64_t PostgresRows::NextInteger() { return std::strtoll(NextValue(), nullptr, 10); }

double PostgresRows::NextReal() { return std::strtod(NextValue(), nullptr); }

bool PostgresRows::NextBool() { return *NextValue() == 't'; }

std::string PostgresRows::NextText() { return NextValue(); }

std::string PostgresRows::NextBytes() {
  const absl::string_view text = NextValue();
  return absl::HexStringToBytes(text.substr(std::min<std::size_t>(2, text.size())));
}

bool PostgresRows::NextIsNull() const { return PQgetisnull(result_.get(), row_, column_) != 0; }

std::int64_t PostgresRows::count() const {
  return std::strtoll(PQcmdTuples(result_.get()), nullptr, 10);
}

void PostgresConnection::Finish::operator()(pg_conn* connection) const { PQfinish(connection); }

PostgresConnection::PostgresConnection(pg_conn* connection, std::chrono::milliseconds timeout)
    : connection_(connection), timeout_(timeout) {}

PostgresConnection::~PostgresConnection() = default;

absl::StatusOr<std::unique_ptr<PostgresConnection>> PostgresConnection::Open(
    const PostgresOptions& options) {
  // The address may name parameters that these are the defaults of.
  const char* const keys[] = {"application_name", "client_encoding", "dbname", nullptr};
  const char* const values[] = {"dcloc-server", "UTF8", options.address.c_str(), nullptr};
  pg_conn* raw = PQconnectStartParams(keys, values, /*expand_dbname=*/1);
  if (raw == nullptr) return absl::ResourceExhaustedError("database: no memory is left");
  std::unique_ptr<PostgresConnection> connection(
      new PostgresConnection(raw, options.statement_timeout));
  absl::Status status = connection->Connect(Clock::now() + options.connect_timeout);
  if (status.ok()) status = connection->SetUp();
  if (!status.ok()) return status;
  return connection;
}

absl::Status PostgresConnection::Connect(Clock::time_point deadline) {
  PQsetNoticeReceiver(connection_.get(), &IgnoreNotice, nullptr);
  if (PQstatus(connection_.get()) == CONNECTION_BAD) return Lost("cannot connect");
  PostgresPollingStatusType next = PGRES_POLLING_WRITING;
  while (next != PGRES_POLLING_OK) {
    if (next == PGRES_POLLING_FAILED) return Lost("cannot connect");
    const absl::Status status = Wait(next == PGRES_POLLING_READING ? POLLIN : POLLOUT, deadline);
    if (!status.ok()) return status;
    next = PQconnectPoll(connection_.get());
  }
  return PQsetnonblocking(connection_.get(), 1) == 0 ? absl::OkStatus() : Lost("cannot connect");
}

absl::Status PostgresConnection::SetUp() {
  const std::int64_t timeout_ms = timeout_.count();
  // Doubles are written so that reading them gives the same double.
  return RunAll(absl::StrFormat("SET search_path = dcloc, public; SET extra_float_digits = 1;"
                                "SET statement_timeout = %d; SET lock_timeout = %d;"
                                "SET idle_in_transaction_session_timeout = %d;"
                                "SET DateStyle = 'ISO'",
                                timeout_ms, timeout_ms / 2, 2 * timeout_ms),
                timeout_)
      .status();
}

absl::StatusOr<PostgresRows> PostgresConnection::Query(const char* sql,
                                                       const PostgresValues& values) {
  if (lost_) return absl::UnavailableError(kDatabaseIsAway);
  if (values.has_nul_) return absl::InvalidArgumentError("a text for the database has a NUL byte");
  std::vector<const char*> texts;
  for (const auto& text : values.texts_) texts.push_back(text ? text->c_str() : nullptr);
  const Clock::time_point deadline = Clock::now() + timeout_ + kAnswerGrace;
  const int sent = PQsendQueryParams(connection_.get(), sql, static_cast<int>(texts.size()),
                                     nullptr, texts.data(), nullptr, nullptr, /*resultFormat=*/0);
  if (sent == 0) return Lost("statement not sent");
  return Receive(deadline);
}

absl::Status PostgresConnection::SetStatementTimeout(std::chrono::milliseconds timeout) {
  return RunAll(absl::StrFormat("SET statement_timeout = %d", timeout.count()), timeout_).status();
}

absl::StatusOr<PostgresRows> PostgresConnection::QueryWhole(const std::string& sql) {
  const std::chrono::milliseconds timeout = std::max(timeout_, kWholeTableTimeout);
  if (absl::Status status = SetStatementTimeout(timeout); !status.ok()) return status;
  absl::StatusOr<PostgresRows> rows = RunAll(sql, timeout + kAnswerGrace);
  if (lost_) return rows;
  if (absl::Status status = SetStatementTimeout(timeout_); !status.ok())
    return Lost("not set back");
  return rows;
}

absl::StatusOr<PostgresRows> PostgresConnection::RunAll(const std::string& sql,
                                                        std::chrono::milliseconds timeout) {
  if (lost_) return absl::UnavailableError(kDatabaseIsAway);
  const Clock::time_point deadline = Clock::now() + timeout;
  if (PQsendQuery(connection_.get(), sql.c_str()) == 0) return Lost("statement not sent");
  return Receive(deadline);
}

bool PostgresConnection::IsIdle() const {
  if (lost_ || PQstatus(connection_.get()) != CONNECTION_OK) return false;
  if (PQtransactionStatus(connection_.get()) != PQTRANS_IDLE) return false;
  // An idle database says nothing, unless it says that it ends.
  pollfd ready{.fd = descriptor(), .events = POLLIN, .revents = 0};
  return poll(&ready, 1, 0) == 0;
}

absl::StatusOr<bool> PostgresConnection::TakeNotifications() {
  if (lost_ || PQconsumeInput(connection_.get()) == 0) return Lost("connection lost");
  bool is_notified = false;
  while (PGnotify* notification = PQnotifies(connection_.get())) {
    PQfreemem(notification);
    is_notified = true;
  }
  return is_notified;
}

int PostgresConnection::descriptor() const { return PQsocket(connection_.get()); }

absl::Status PostgresConnection::Wait(short events, Clock::time_point deadline) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return Lost("no answer in time");
    pollfd ready{.fd = descriptor(), .events = events, .revents = 0};
    const int count = poll(&ready, 1, static_cast<int>(left.count()));
    if (count > 0) return absl::OkStatus();
    if (count < 0 && errno != EINTR) return Lost(std::strerror(errno));
  }
}

absl::Status PostgresConnection::Flush(Clock::time_point deadline) {
  while (true) {
    const int left = PQflush(connection_.get());
    if (left == 0) return absl::OkStatus();
    if (left < 0) return Lost("statement not sent");
    // What the database says meanwhile must be taken in, or both wait for each other.
    if (absl::Status status = Wait(POLLIN | POLLOUT, deadline); !status.ok()) return status;
    if (PQconsumeInput(connection_.get()) == 0) return Lost("connection lost");
  }
}

absl::StatusOr<PostgresRows> PostgresConnection::Receive(Clock::time_point deadline) {
  if (absl::Status status = Flush(deadline); !status.ok()) return status;
  absl::Status status;
  PostgresRows last(nullptr);
  while (true) {
    while (PQisBusy(connection_.get()) != 0) {
      if (absl::Status waited = Wait(POLLIN, deadline); !waited.ok()) return waited;
      if (PQconsumeInput(connection_.get()) == 0) return Lost("connection lost");
    }
    PostgresRows rows(PQgetResult(connection_.get()));
    if (rows.result_ == nullptr) break;
    status.Update(StatusOf(rows.result_.get()));
    last = std::move(rows);
  }
  if (PQstatus(connection_.get()) == CONNECTION_BAD) {
    return Lost(status.ok() ? "connection lost" : status.message());
  }
  if (!status.ok()) return status;
  return last;
}

absl::Status PostgresConnection::Lost(absl::string_view reason) {
  lost_ = true;
  const absl::string_view detail =
      absl::StripAsciiWhitespace(absl::string_view(PQerrorMessage(connection_.get())));
  return AwayError(detail.empty() ? reason : detail);
}

}  // namespace dcloc::server
