#pragma once

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

struct pg_result;

namespace dcloc::server {

/// What a client is told when the database is away: nothing of where it is, but what to do.
inline constexpr char kDatabaseIsAway[] =
    "the database of the catalogue cannot be reached; try again in a few seconds";

/// Unavailable with `kDatabaseIsAway`, and the reason beside it for the log (`AwayReason`).
absl::Status AwayError(absl::string_view reason);

/// Whether an error is one of a database that is away, and not of one that is busy.
bool IsAway(const absl::Status& status);

/// Why it is away.
std::string AwayReason(const absl::Status& status);

/// OK, or the error that the database answered with.
absl::Status StatusOf(const pg_result* result);

}  // namespace dcloc::server
