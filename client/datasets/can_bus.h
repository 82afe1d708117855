#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "core/radar/ego_velocity.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// A vehicle's velocity over time, as its bus reports it.
class VelocityLog {
 public:
  struct Sample {
    Stamp stamp;
    Eigen::Vector3d linear_mps;
    Eigen::Vector3d angular_radps;
  };

  /// `samples` by ascending stamp.
  explicit VelocityLog(std::vector<Sample> samples) : samples_(std::move(samples)) {}

  /// The velocity at `stamp`, linear between the samples around it; at the log's ends the nearest
  /// sample's. Absent when no sample lies within `max_age` of it.
  std::optional<EgoVelocity> At(Stamp stamp, std::chrono::nanoseconds max_age) const;

 private:
  std::vector<Sample> samples_;
};

/// Reads `vel` and `rotation_rate` of a `can_bus/<scene>_pose.json` of the CAN bus expansion; the
/// file's positions are not looked at. DataLoss names the file and what is wrong.
absl::StatusOr<VelocityLog> ReadCanBusPose(const std::filesystem::path& path);

}  // namespace dcloc
