#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "core/localizer/localizer.h"

namespace dcloc {

/// The error of the initial pose that a localizer is given.
struct Perturbation {
  double translation_m = 1.0;  ///< exactly, in a random direction in the plane, [0, 1000]
  double rotation_deg = 2.0;   ///< exactly, about the vertical to a random side, [0, 180]
  std::uint64_t seed = 1;
};

/// OK, or InvalidArgument that names the field, as "perturbation.translation_m", the value and the
/// bound.
absl::Status Validate(const Perturbation& perturbation);

/// The perturbed true pose, with the covariance of the perturbation: (translation_m)^2 / 2 along x
/// and y each, (rotation_deg)^2 in yaw, but never less than (5 cm)^2 and (0.1 deg)^2; 0.1 m and 0.5
/// deg in z, roll and pitch, which are not perturbed. The same drive, query and seed give the same
/// pose.
InitialPose Perturb(const Pose3& T_map_vehicle_true, const Perturbation& perturbation,
                    const std::string& drive, std::uint64_t query);

}  // namespace dcloc
