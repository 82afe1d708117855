#include "server/base/sqlite_steps.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

absl::StatusOr<std::int64_t> TakenCount(SqliteDatabase& database) {
  SqliteStatement query(database, "PRAGMA user_version");
  const absl::StatusOr<bool> row = query.Step();
  if (!row.ok()) return row.status();
  return *row ? query.NextInteger() : 0;
}

}  // namespace

absl::Status TakeSteps(SqliteDatabase& database, absl::string_view what,
                       std::span<const char* const> steps) {
  const absl::StatusOr<std::int64_t> taken = TakenCount(database);
  if (!taken.ok()) return taken.status();
  const auto count = static_cast<std::int64_t>(steps.size());
  if (*taken > count || *taken < 0) {
    return absl::FailedPreconditionError(absl::StrCat(what, ": its tables are of step ", *taken,
                                                      ", from a newer program; this program knows ",
                                                      count));
  }
  absl::Status status = database.Run("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;");
  if (!status.ok() || *taken == count) return status;
  SqliteTransaction transaction(database);
  status = transaction.status();
  for (auto step = static_cast<std::size_t>(*taken); status.ok() && step < steps.size(); ++step) {
    status = database.Run(steps[step]);
  }
  if (status.ok()) status = database.Run(absl::StrCat("PRAGMA user_version = ", count).c_str());
  return status.ok() ? transaction.Commit() : status;
}

}  // namespace dcloc::server
