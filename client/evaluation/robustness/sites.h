#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "absl/status/statusor.h"
#include "client/evaluation/robustness/campaign.h"

namespace dcloc::robustness {

/// Simulated towns and highways, ARS408-like and CARLA-like, mapped at 72 km/h and driven at other
/// speeds; worlds and drives follow from `seed`. `quick` makes a few short ones.
std::vector<Site> SimulatedSites(std::uint64_t seed, bool quick);

/// The recordings in `folder`, each drive in parts of 20 s with every kind of disturbance, and
/// starts along it. Errors as of paper::RecordedCases.
absl::StatusOr<std::vector<Site>> RecordedSites(const std::filesystem::path& folder,
                                                std::uint64_t seed);

}  // namespace dcloc::robustness
