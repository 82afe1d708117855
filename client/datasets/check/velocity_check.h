#pragma once

#include <cstddef>
#include <optional>

#include "client/datasets/drive.h"

namespace dcloc {

/// What the velocities that a vehicle sends are, beside how it moved by its reference poses.
struct VelocityCheck {
  std::size_t scan_count = 0;
  std::size_t velocity_count = 0;  ///< scans with a velocity
  /// Reported speed by the true one, the least-squares factor; nothing while it stands, or without
  /// reference poses.
  std::optional<double> speed_factor;
  /// The same of yaw rates; nothing on a drive that is too straight to tell.
  std::optional<double> yaw_rate_factor;
  /// By how much later velocities are than poses [s]; nothing where speed and yaw rate change too
  /// little to tell.
  std::optional<double> delay_s;
};

/// Velocities of Doppler are not the vehicle's, and are not looked at.
VelocityCheck CheckVelocities(const Drive& drive);

}  // namespace dcloc
