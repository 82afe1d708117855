#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dcloc {

/// OK when every one of `wanted` is one of `available` and none is asked for twice; otherwise
/// NotFound or InvalidArgument that names it and the available ones.
absl::Status CheckRadars(const std::vector<std::string>& wanted,
                         const std::vector<std::string>& available);

/// True when `id` is to be read: it is one of `wanted`, or nothing in particular is wanted.
bool IsWanted(const std::vector<std::string>& wanted, absl::string_view id);

}  // namespace dcloc
