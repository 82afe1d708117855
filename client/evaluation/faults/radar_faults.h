#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

// Each changes the scans that were measured within the window.

/// No scan of `radar_id` arrives; of none where it is absent.
void SilenceRadar(Stream& stream, const Window& window, const std::optional<std::string>& radar_id);

/// Azimuths of `radar_id` have the other sign.
void MirrorAzimuth(Stream& stream, const Window& window, const std::string& radar_id);

/// `radar_id` has been knocked: it looks `yaw_rad` further to the left than the rig says.
void KnockRadar(Stream& stream, const Window& window, const std::string& radar_id, double yaw_rad);

/// The rig says that `radar_id` looks `yaw_rad` further to the left than it does; from the start.
void TurnMount(Stream& stream, const std::string& radar_id, double yaw_rad);

/// Range rates of `radar_id` are multiplied and shifted; the ranges stay.
void ChangeRangeRate(Stream& stream, const Window& window, const std::string& radar_id,
                     double factor, double offset_mps = 0.0);

/// Every target of every radar states `sigma` as the deviation of its range [m], range rate [m/s],
/// azimuth [rad] and, where the scan has one, elevation [rad].
void StateSigmas(Stream& stream, const Window& window, float sigma);

/// Of the radars; "one radar" is the first of the rig.
std::vector<Fault> RadarFaults();

}  // namespace dcloc::faults
