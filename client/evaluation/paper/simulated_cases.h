#pragma once

#include <vector>

#include "client/evaluation/paper/study.h"

namespace dcloc::paper {

/// The study's own drives, simulated when they are needed: a map pass at 72 km/h and live passes at
/// 40 km/h and at changing speeds, through towns and along highways, with ARS408-like and
/// CARLA-like radars; and the four noises of Table IV. `quick` makes a few short ones.
std::vector<Case> SimulatedCases(bool quick);

}  // namespace dcloc::paper
