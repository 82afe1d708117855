#pragma once

#include <algorithm>
#include <cstddef>

/// Two ways to thin a list. Both keep its order and are the same for the same sizes.
namespace dcloc {

/// Index of the `i`-th of `count` items that lie evenly among `size`: exactly `count` remain, at
/// steps that differ by one at most. `count` is at most `size`.
constexpr std::size_t EvenIndex(std::size_t i, std::size_t count, std::size_t size) {
  return i * size / count;
}

/// The least step n such that each n-th of `size` items leaves at most `max_count`. The steps are
/// equal, so that as few as half of `max_count` may remain.
constexpr std::size_t StepToKeep(std::size_t max_count, std::size_t size) {
  return std::max<std::size_t>(1, (size + max_count - 1) / max_count);
}

}  // namespace dcloc
