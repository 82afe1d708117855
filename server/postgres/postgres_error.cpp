#include "server/postgres/postgres_error.h"

#include <libpq-fe.h>

#include "absl/strings/cord.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

constexpr char kReasonUrl[] = "dcloc/database-away";

/// By the classes of appendix A of PostgreSQL's manual.
absl::StatusCode CodeOf(absl::string_view sql_state) {
  if (sql_state == "23505") return absl::StatusCode::kAlreadyExists;  // unique_violation
  if (sql_state == "55P03" || sql_state == "57014" ||                 // lock_timeout, too long
      sql_state == "25006" || absl::StartsWith(sql_state, "40")) {    // a standby; serialization
    return absl::StatusCode::kUnavailable;
  }
  if (absl::StartsWith(sql_state, "53")) return absl::StatusCode::kResourceExhausted;
  if (sql_state == "XX001" || sql_state == "XX002") return absl::StatusCode::kDataLoss;
  return absl::StatusCode::kInternal;
}

/// It ends, has not begun, takes no more connections, or the connection broke.
bool IsAwayState(absl::string_view sql_state) {
  return absl::StartsWith(sql_state, "57P") || absl::StartsWith(sql_state, "08") ||
         sql_state == "53300" || sql_state == "25P03";
}

}  // namespace

absl::Status AwayError(absl::string_view reason) {
  absl::Status status = absl::UnavailableError(kDatabaseIsAway);
  status.SetPayload(kReasonUrl, absl::Cord(reason));
  return status;
}

bool IsAway(const absl::Status& status) { return status.GetPayload(kReasonUrl).has_value(); }

std::string AwayReason(const absl::Status& status) {
  const auto reason = status.GetPayload(kReasonUrl);
  return reason ? std::string(*reason) : std::string(status.message());
}

absl::Status StatusOf(const pg_result* result) {
  const ExecStatusType status = PQresultStatus(result);
  if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return absl::OkStatus();
  const char* const field = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const absl::string_view sql_state = field == nullptr ? "" : field;
  const char* const primary = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  const absl::string_view message = primary == nullptr ? PQresultErrorMessage(result) : primary;
  // Without a state libpq itself reports it: the connection was lost.
  if (sql_state.empty() || IsAwayState(sql_state)) return AwayError(message);
  return absl::Status(CodeOf(sql_state), absl::StrCat("database: ", message, " (", sql_state, ")"));
}

}  // namespace dcloc::server
