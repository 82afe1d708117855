#pragma once

#include <span>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/base/sqlite.h"

namespace dcloc::server {

/// Makes the tables of a database that a server may lose less than a commit of, as a list of steps
/// that is only ever added to; its `user_version` counts those that are made. FailedPrecondition
/// when a newer program has made more: then nothing is changed. `what` names the database.
absl::Status TakeSteps(SqliteDatabase& database, absl::string_view what,
                       std::span<const char* const> steps);

}  // namespace dcloc::server
