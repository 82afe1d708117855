#pragma once

#include <functional>
#include <string>

#include "absl/status/statusor.h"

namespace dcloc::faults {

/// What `work` gives, done in a process of its own, so that neither a crash nor an endless loop
/// ends the caller: Aborted says by which signal it ended (by SIGXCPU after `limit_s` (> 0) of
/// processor time), Internal that no process could be made. `work` starts no threads, waits for
/// nothing, and what it changes in memory is lost.
absl::StatusOr<std::string> RunIsolated(const std::function<std::string()>& work,
                                        unsigned int limit_s);

}  // namespace dcloc::faults
