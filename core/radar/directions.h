#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace dcloc {

/// Ten degrees wide, all around the vehicle.
inline constexpr int kDirectionCount = 36;

/// Directions in which something is seen. One mover fills few, what stands still many.
using Directions = std::bitset<kDirectionCount>;

/// The direction that a line of sight in the vehicle frame lies in, [0, kDirectionCount).
inline int DirectionOf(const Eigen::Vector3d& u_vehicle) {
  const double turns = std::atan2(u_vehicle.y(), u_vehicle.x()) / (2.0 * std::numbers::pi) + 0.5;
  return std::min(kDirectionCount - 1, static_cast<int>(turns * kDirectionCount));
}

/// How many directions the items lie in, by the member `direction` of each.
template <typename Items>
int CountDirections(const Items& items) {
  Directions directions;
  for (const auto& item : items) directions.set(static_cast<std::size_t>(item.direction));
  return static_cast<int>(directions.count());
}

/// Gives the `vote` of each item: 1, or less where many lie in one direction, which have together
/// at most `max_direction_fraction` of the items' number. Returns the sum of all votes.
template <typename Items>
double ShareVotes(double max_direction_fraction, Items& items) {
  std::array<int, kDirectionCount> counts{};
  for (const auto& item : items) ++counts[static_cast<std::size_t>(item.direction)];
  const double max_votes =
      std::max(1.0, max_direction_fraction * static_cast<double>(items.size()));
  double sum = 0.0;
  for (auto& item : items) {
    item.vote = std::min(1.0, max_votes / counts[static_cast<std::size_t>(item.direction)]);
    sum += item.vote;
  }
  return sum;
}

}  // namespace dcloc
