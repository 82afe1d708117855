#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/geometry/pose.h"
#include "core/map/keyframe_accuracy.h"

namespace dcloc {

/// A landmark: the fused returns of one scatterer, in its keyframe's frame. Stored as is in the
/// file.
struct MapPoint {
  float x_m, y_m;
  /// If `MapInfo::has_heights`: the height over the radars that saw it.
  float z_m;
  /// Where a further return of this scatterer may lie, without that return's own noise [m^2].
  float xx_m2, xy_m2, xz_m2, yy_m2, yz_m2, zz_m2;
  float rcs_dbsm;
  std::uint16_t scan_count;  ///< scans that saw it, saturating
  std::uint16_t pass_count;  ///< separate passes that saw it, saturating
};
static_assert(sizeof(MapPoint) == 44);

/// A vehicle pose on the mapping drive, and the landmarks nearest to it.
struct Keyframe {
  Pose3 T_map_keyframe;  ///< a vehicle pose: x ahead, y left, z up
  std::span<const MapPoint> points;
};

/// What a map is, without its points.
struct MapInfo {
  std::string name;         ///< of the drive that the map was made from
  std::string description;  ///< command and radars, for people
  std::uint64_t keyframe_count = 0;
  std::uint64_t point_count = 0;
  std::uint64_t size_bytes = 0;
  double length_m = 0.0;                                ///< of street, along the mapping drive
  Eigen::Vector3d min_map_m = Eigen::Vector3d::Zero();  ///< bounds of the keyframes' positions
  Eigen::Vector3d max_map_m = Eigen::Vector3d::Zero();
  bool has_elevation = false;  ///< points were measured in three dimensions
  bool has_heights = false;    ///< planar; heights were found from slant ranges
  /// Present where it was known how late the radars that made it stamp their scans, so that points
  /// lie where they were measured: by how much later than described, on average.
  std::optional<double> stamp_delay_s;
  std::optional<GeodeticAnchor> anchor;
};

/// An immutable map, memory-mapped from its file or held in memory; safe to share between threads.
/// maps/FORMAT.md describes the file's bytes. Whatever the bytes are, no call reads outside of
/// them; `Verify` checks that they are intact.
class RadarMap {
 public:
  /// Maps the file; checks everything but the points and their checksum, at a cost that grows with
  /// the keyframes only. Nobody may change or truncate the file while it is open: reading beyond
  /// its new end faults (SIGBUS). Replace files by renaming, as the server's store does. Errors
  /// name the file: NotFound and what else the system says, or DataLoss with what is wrong.
  static absl::StatusOr<std::shared_ptr<const RadarMap>> Open(const std::filesystem::path& path);

  /// The same from bytes in memory (what MapBuilder makes).
  static absl::StatusOr<std::shared_ptr<const RadarMap>> FromBytes(std::vector<std::byte> bytes);

  RadarMap(const RadarMap&) = delete;
  RadarMap& operator=(const RadarMap&) = delete;
  ~RadarMap();

  const MapInfo& info() const;
  std::span<const std::byte> bytes() const;

  /// Reads everything: checksums, finite values, positive semidefinite covariances. DataLoss names
  /// the first fault.
  absl::Status Verify() const;

  /// Keyframe `index` < info().keyframe_count.
  Keyframe keyframe(std::size_t index) const;

  /// What vehicles can expect there; absent where the map does not say.
  std::optional<KeyframeAccuracy> accuracy(std::size_t index) const;

  /// Indices, ascending, of the keyframes whose position lies within `radius_m` of `p_map` in the
  /// map's xy plane. The cost grows with the keyframes found, not with the size of the map.
  std::vector<std::size_t> KeyframesWithin(const Eigen::Vector3d& p_map, double radius_m) const;

  /// The same, into `indices`, whose former contents are replaced; its memory is reused.
  void KeyframesWithin(const Eigen::Vector3d& p_map, double radius_m,
                       std::vector<std::size_t>& indices) const;

  /// The keyframe nearest to `p_map` in the xy plane, if one lies within `max_distance_m`.
  std::optional<std::size_t> NearestKeyframe(const Eigen::Vector3d& p_map,
                                             double max_distance_m) const;

 private:
  class Storage;
  struct Layout;
  RadarMap(std::unique_ptr<Storage> storage, std::unique_ptr<Layout> layout);
  static absl::StatusOr<std::shared_ptr<const RadarMap>> Load(std::unique_ptr<Storage> storage);

  std::unique_ptr<Storage> storage_;
  std::unique_ptr<Layout> layout_;
};

}  // namespace dcloc
