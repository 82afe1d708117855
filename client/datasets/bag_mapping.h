#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/pose.h"

namespace dcloc {

/// Name of the file beside the bags of a folder that says what they hold.
inline constexpr const char* kBagMappingFileName = "dcloc_bag.json";

/// How a topic of point clouds becomes the scans of a radar. Fields are named; a name that is empty
/// is not there. Targets are given by range and azimuth, or by x and y.
struct RadarMapping {
  std::string id;
  std::string topic;
  std::string range;
  std::string azimuth;
  std::string elevation;
  std::string x;
  std::string y;
  std::string z;  ///< with x and y: empty for a radar that measures no elevation
  std::string range_rate;
  std::string rcs;                         ///< in dBsm
  bool angles_in_degrees = false;          ///< in place of radians
  bool azimuth_is_clockwise = false;       ///< in place of counter-clockwise from x (REP 103)
  bool range_rate_is_towards = false;      ///< positive for what comes nearer
  bool range_rate_is_compensated = false;  ///< over ground: the vehicle's own motion is taken out
  std::optional<Pose3> T_vehicle_radar;    ///< in place of the one that TF tells

  bool IsPolar() const { return !range.empty(); }
  bool HasElevation() const { return IsPolar() ? !elevation.empty() : !z.empty(); }
};

/// What the topics of a bag are.
struct BagMapping {
  std::vector<RadarMapping> radars;
  std::string motion_topic;  ///< Odometry or Twist*Stamped; empty: Doppler alone
  std::string imu_topic;     ///< Imu, whose turn rates replace those of `motion_topic`
  /// Odometry, Pose*Stamped, or NavSatFix (fix_poses.h); empty: TF, where it knows.
  std::string reference_topic;
  /// A text file of poses, `stamp x y z qx qy qz qw` with stamps in seconds, in place of a topic;
  /// its path is absolute or from the bag's folder.
  std::string reference_file;
  std::string vehicle_frame = "base_link";
  std::string map_frame = "map";
  /// Nothing says how fast the vehicle is but the radars (doppler_velocity.h); the turn rate is
  /// that of `imu_topic`.
  bool velocity_by_doppler = false;
  /// Where the frames of `reference_*` and `imu_topic` sit, in place of what TF tells.
  std::optional<Pose3> T_vehicle_reference;
  std::optional<Pose3> T_vehicle_imu;
};

/// OK, or InvalidArgument that names the radar and the field: each radar has an id and a topic of
/// its own, its range rate, and range with azimuth or x with y; velocities by Doppler need an
/// imu_topic, and stand in place of a motion_topic; references are of a topic or of a file.
absl::Status Validate(const BagMapping& mapping);

/// Reads the file. DataLoss that names the path and the key, for unknown keys too.
absl::StatusOr<BagMapping> ReadBagMapping(const std::filesystem::path& path);

/// What `ReadBagMapping` reads.
nlohmann::ordered_json BagMappingJson(const BagMapping& mapping);

}  // namespace dcloc
