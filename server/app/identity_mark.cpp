#include "server/app/identity_mark.h"

#include "absl/strings/str_format.h"
#include "server/app/storage.h"
#include "server/base/files.h"
#include "server/base/sqlite.h"

namespace dcloc::server {
namespace {

// That the table is there is the mark. So the schema's version stays, and other programs of this
// version read the catalogue as before.
constexpr char kSetMark[] = "CREATE TABLE IF NOT EXISTS identity_seen (at INTEGER) STRICT";
constexpr char kFindMark[] = "SELECT 1 FROM sqlite_master WHERE name = 'identity_seen'";

}  // namespace

absl::StatusOr<bool> HasIdentityMark(const std::filesystem::path& folder) {
  absl::StatusOr<SqliteDatabase> catalogue =
      SqliteDatabase::Open(PathsOf(folder).catalogue, SqliteAccess::kRead);
  if (absl::IsNotFound(catalogue.status())) return false;
  if (!catalogue.ok()) return catalogue.status();
  return SqliteStatement(*catalogue, kFindMark).Step();
}

absl::Status SetIdentityMark(const std::filesystem::path& folder) {
  const absl::StatusOr<std::int64_t> size = FileSize(PathsOf(folder).catalogue);
  if (!size.ok() || *size == 0) return size.status();
  absl::StatusOr<SqliteDatabase> catalogue = SqliteDatabase::Open(PathsOf(folder).catalogue);
  return catalogue.ok() ? catalogue->Run(kSetMark) : catalogue.status();
}

absl::Status CheckNoIdentityIsLost(const std::filesystem::path& folder) {
  const absl::StatusOr<bool> seen = HasIdentityMark(folder);
  if (!seen.ok() || !*seen) return seen.status();
  return absl::FailedPreconditionError(absl::StrFormat(
      "%s: identities.sqlite is missing or empty, and the catalogue has seen identities: without "
      "them everyone would be an admin. Put a backup's identities.sqlite in place, or make new "
      "ones, beginning with \"dcloc-server token create --data %s --name NAME --role admin\"",
      folder.string(), folder.string()));
}

}  // namespace dcloc::server
