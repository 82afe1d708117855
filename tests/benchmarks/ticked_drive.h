#pragma once

#include "client/datasets/drive.h"
#include "client/simulation/simulation.h"

namespace dcloc::benchmarks {

/// The drive of `pass` with at most `scan_rate_hz` scans a second, and with the ticks that the SDK
/// sends along: those that have come when the first tick after a scan has. Of the bus each
/// `signals_a_tick`-th signal is a tick; none for 0.
Drive TickedDrive(const SimulatedPass& pass, double scan_rate_hz, int signals_a_tick);

}  // namespace dcloc::benchmarks
