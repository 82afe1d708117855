#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "server/passes/pass_rows.h"

namespace dcloc::server {

/// Passes for an update, and which of them judges it.
struct PassChoice {
  std::vector<PassRow> passes;
  std::size_t held_out = 0;
};

/// Chooses the passes that were kept after `since`, the newest first, as far as `max_bytes` and a
/// hundred passes go. The longest judges of those that leave two witnesses besides: passes of one
/// vehicle on one day are one witness, and those of the judge's take no part. `rows` are newest
/// first. FailedPrecondition says how many passes and witnesses there are.
absl::StatusOr<PassChoice> ChoosePasses(const std::vector<PassRow>& rows, SystemTime since,
                                        std::int64_t max_bytes);

}  // namespace dcloc::server
