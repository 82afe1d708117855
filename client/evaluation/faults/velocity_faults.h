#pragma once

#include <vector>

#include "client/evaluation/faults/fault.h"

namespace dcloc::faults {

// Each changes the reported velocities of the scans that were measured within the window; scans
// without one stay so. Stated covariances stay as they are.

/// Multiplies speeds and turn rates.
void ScaleVelocity(Stream& stream, const Window& window, double linear_factor,
                   double angular_factor);

/// Multiplies speeds by 1 at the window's begin, by `factor` from `ramp_s` later on, and by what is
/// linear between.
void RampSpeed(Stream& stream, const Window& window, double factor, double ramp_s);

/// Reports what the last scan before the window did, or the first one of the drive.
void FreezeVelocity(Stream& stream, const Window& window);

/// Adds to the forward speed.
void BiasSpeed(Stream& stream, const Window& window, double bias_mps);

/// Adds `bias_radps` to the yaw rate.
void BiasYawRate(Stream& stream, const Window& window, double bias_radps);

/// Reports forward speed and yaw rate in steps, and no speed below `least_mps`.
void RoundVelocity(Stream& stream, const Window& window, double step_mps, double least_mps,
                   double step_radps);

/// Reports the speed along the vehicle's axis without its sign.
void UnsignSpeed(Stream& stream, const Window& window);

/// Reports the velocity of `delay_s` before, linear between the scans around that moment; the first
/// scan's where that is before the drive.
void DelayVelocity(Stream& stream, const Window& window, double delay_s);

/// Reports none.
void DropVelocity(Stream& stream, const Window& window);

/// Only every `interval`th scan reports a velocity.
void ThinVelocity(Stream& stream, const Window& window, int interval);

/// States the deviation `sigma` of each component, m/s and rad/s, independent of one another.
void StateVelocitySigma(Stream& stream, const Window& window, double sigma);

/// Of wheels and gyroscope.
std::vector<Fault> VelocityFaults();

}  // namespace dcloc::faults
