#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/passes/placed_pass.h"

namespace dcloc {

/// How a radar looked at a place: bins of range, of bearing, and whether a nearer target lay at the
/// same bearing.
inline constexpr std::size_t kRangeBinCount = 9;
inline constexpr std::size_t kBearingBinCount = 6;  ///< of 15 degrees, to either side
inline constexpr std::size_t kExposureBinCount = kRangeBinCount * kBearingBinCount * 2;

/// Of one place in one pass: the scans that looked at it so.
using Exposure = std::array<std::uint16_t, kExposureBinCount>;

/// The exposures of `places_m`, relative to `origin_m` of the map, by the scans of `pass` that are
/// chosen.
std::vector<Exposure> Expose(const PlacedPass& pass, const Eigen::Vector3d& origin_m,
                             std::span<const Eigen::Vector2d> places_m, ScanChoice choice);

/// What a vehicle with `rig` would see of `places_m` from each of `T_local_vehicles`, were nothing
/// hidden.
std::vector<Exposure> ExposeFrom(std::span<const Pose3> T_local_vehicles, const Rig& rig,
                                 std::span<const Eigen::Vector2d> places_m);

}  // namespace dcloc
