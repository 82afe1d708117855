#include "client/trajectory/decimal_stamp.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"

namespace dcloc {

std::optional<Stamp> StampOfSeconds(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('.', 1));
  constexpr std::int64_t kMaxSeconds = 9'000'000'000;
  const bool is_digits = std::ranges::all_of(parts.first, absl::ascii_isdigit) &&
                         std::ranges::all_of(parts.second, absl::ascii_isdigit);
  if (!is_digits || parts.first.empty()) {
    double value = 0.0;
    if (!absl::SimpleAtod(text, &value) || !(value >= 0.0 && value < double{kMaxSeconds})) {
      return std::nullopt;
    }
    return Stamp(std::chrono::nanoseconds(std::llround(value * 1e9)));
  }
  std::string fraction(parts.second.substr(0, 9));
  fraction.resize(9, '0');
  std::int64_t seconds = 0;
  std::int64_t nanoseconds = 0;
  const bool is_read =
      absl::SimpleAtoi(parts.first, &seconds) && absl::SimpleAtoi(fraction, &nanoseconds);
  if (!is_read || seconds > kMaxSeconds) return std::nullopt;
  return Stamp(std::chrono::seconds(seconds) + std::chrono::nanoseconds(nanoseconds));
}

}  // namespace dcloc
