#pragma once

#include <array>
#include <string>
#include <utility>

#include "client/simulation/simulation_options.h"

namespace dcloc {

/// The choices of a simulation by the names that users write.
inline constexpr std::array<std::pair<const char*, WorldKind>, 2> kWorldNames = {
    {{"town", WorldKind::kTown}, {"highway", WorldKind::kHighway}}};
inline constexpr std::array<std::pair<const char*, RadarKind>, 2> kRadarNames = {
    {{"ars408", RadarKind::kArs408}, {"carla", RadarKind::kCarla}}};
inline constexpr std::array<std::pair<const char*, NoiseKind>, 4> kNoiseNames = {
    {{"gaussian", NoiseKind::kGaussian},
     {"gamma", NoiseKind::kGamma},
     {"student", NoiseKind::kStudent},
     {"rayleigh", NoiseKind::kRayleigh}}};

inline constexpr const auto& NamesFor(WorldKind) { return kWorldNames; }
inline constexpr const auto& NamesFor(RadarKind) { return kRadarNames; }
inline constexpr const auto& NamesFor(NoiseKind) { return kNoiseNames; }

/// The name of `kind`.
template <typename Kind>
std::string NameOf(Kind kind) {
  for (const auto& [name, value] : NamesFor(kind)) {
    if (value == kind) return name;
  }
  return "";
}

}  // namespace dcloc
