#pragma once

#include <algorithm>
#include <cstddef>
#include <ranges>
#include <vector>

/// Two ways to thin a list. Both keep its order and are the same for the same sizes.
namespace dcloc {

/// Index of the `i`-th of `count` items that lie evenly among `size`: exactly `count` remain, at
/// steps that differ by one at most. `count` is at most `size`.
constexpr std::size_t EvenIndex(std::size_t i, std::size_t count, std::size_t size) {
  return i * size / count;
}

/// Calls `take` with each of up to `max_count` of the items, which lie evenly among them.
template <typename Items, typename Take>
void TakeEvenly(const Items& items, int max_count, const Take& take) {
  const std::size_t count = std::min(items.size(), static_cast<std::size_t>(max_count));
  for (std::size_t i = 0; i < count; ++i) take(items[EvenIndex(i, count, items.size())]);
}

/// Up to `max_count` of the items, evenly among them.
template <typename Items>
std::vector<std::ranges::range_value_t<Items>> EvenSubsample(const Items& items, int max_count) {
  std::vector<std::ranges::range_value_t<Items>> chosen;
  chosen.reserve(std::min(items.size(), static_cast<std::size_t>(max_count)));
  TakeEvenly(items, max_count, [&](const auto& item) { chosen.push_back(item); });
  return chosen;
}

/// The least step n such that each n-th of `size` items leaves at most `max_count`. The steps are
/// equal, so that as few as half of `max_count` may remain.
constexpr std::size_t StepToKeep(std::size_t max_count, std::size_t size) {
  return std::max<std::size_t>(1, (size + max_count - 1) / max_count);
}

}  // namespace dcloc
