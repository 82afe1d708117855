#pragma once

#include <numbers>

namespace dcloc {

/// Angles are in radians, except in input and output for people.
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;

}  // namespace dcloc
