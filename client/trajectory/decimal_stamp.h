#pragma once

#include <optional>

#include "absl/strings/string_view.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// The stamp of a number of seconds since 1970, digit by digit: a double holds today's only to
/// 0.2 us. What is not written in digits alone, as 1.7e9, is a double. Absent where it is no
/// number, negative, or 9e9 and more.
std::optional<Stamp> StampOfSeconds(absl::string_view text);

}  // namespace dcloc
