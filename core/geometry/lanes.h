#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numbers>

/// Arithmetic with four numbers at once, as any processor of 64 bits has it. Compilers understand
/// `+`, `<` and `?:` of such numbers, lane by lane; a comparison gives a mask, to be joined by `&`.
namespace dcloc {

constexpr std::size_t kLaneCount = 4;
using Lanes = float __attribute__((vector_size(4 * kLaneCount)));
using LaneMask = std::int32_t __attribute__((vector_size(4 * kLaneCount)));

/// The same number in each lane.
constexpr Lanes InEachLane(float value) { return Lanes{value, value, value, value}; }

/// The lanes before the `count`-th.
inline LaneMask FirstLanes(std::size_t count) {
  constexpr LaneMask kNumbers = {0, 1, 2, 3};
  const auto end = static_cast<std::int32_t>(count < kLaneCount ? count : kLaneCount);
  return kNumbers < end;
}

/// The larger of two numbers; `floor` where `values` is not a number.
inline Lanes AtLeast(Lanes values, float floor) {
  return values > floor ? values : InEachLane(floor);
}

inline Lanes Abs(Lanes values) { return values < 0.0F ? -values : values; }

/// The smallest number of all lanes.
inline float Least(Lanes values) {
  float least = values[0];
  for (std::size_t lane = 1; lane < kLaneCount; ++lane) least = std::min(least, values[lane]);
  return least;
}

inline Lanes Sqrt(Lanes values) {
  alignas(Lanes) auto numbers = std::bit_cast<std::array<float, kLaneCount>>(values);
  Eigen::Map<Eigen::Array<float, kLaneCount, 1>, Eigen::Aligned16> packet(numbers.data());
  packet = packet.sqrt();
  return std::bit_cast<Lanes>(numbers);
}

/// The logarithms of positive normal numbers, or up to `kLogSlack` less: exponent and mantissa read
/// as one number, a chord below the curve from each power of two to the next.
constexpr float kLogSlack = 0.0597F;
inline Lanes LogFromBelow(Lanes values) {
  constexpr float kOne = 1065353216.0F;  // the bits of 1.0F, read as a number
  constexpr float kLog2 = std::numbers::ln2_v<float> / 8388608.0F;
  return kLog2 * (__builtin_convertvector(std::bit_cast<LaneMask>(values), Lanes) - kOne);
}

}  // namespace dcloc
