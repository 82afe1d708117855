#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/geometry/pose.h"
#include "core/options/option_fields.h"
#include "core/uncertainty/one_sided_cusum.h"

namespace dcloc {

/// When a radar's azimuths are taken with the other sign.
struct AzimuthSignOptions {
  /// One of so many scans of a radar is compared, and all as long as the other sign may fit.
  int scan_interval = 3;
  int max_point_count = 50;  ///< of a scan's points, for as many are laid into the map
  /// Poses are compared as if they were as uncertain as this, at least.
  double min_pose_sigma_m = 0.3;
  /// Standard deviation of what one point adds to the difference of two fits.
  double point_sigma = 0.35;
  /// A mirror image that fits less lies as little in the map as the scan itself: the pose is wrong.
  double min_fit = 0.3;
  /// When scans fit with the other sign for sure.
  OneSidedCusumOptions other_fits = {.drift = 1.0, .max = 4.0, .limit = 8.0};
  // A pose that is wrong may make the mirror image fit better, and one that is turned round does
  // between walls. So both are laid at other poses, too.
  double rival_step_m = 0.5;  ///< distance between neighbouring poses that are compared
  double max_beside_m = 8.0;  ///< distance of the furthest one beside the vehicle
  double max_ahead_m = 24.0;  ///< and of the furthest one ahead and behind
};
std::span<const OptionField<AzimuthSignOptions>> FieldsOf(const AzimuthSignOptions& options);
absl::Status Validate(const AzimuthSignOptions& options);

/// Learns which radars count azimuths in the other direction. From the range rates alone it can
/// not be told from a yaw rate of the wrong sign, and where the vehicle drives straight not at all.
/// The map tells: such a scan's mirror image fits where the vehicle is (METHOD section 18).
class AzimuthSigns {
 public:
  AzimuthSigns(std::size_t radar_count, const AzimuthSignOptions& options);

  const AzimuthSignOptions& options() const { return options_; }

  /// T_vehicle_pose of the poses that both are laid at: the supposed one first, those beside it,
  /// either way round, and those ahead and behind.
  std::span<const Pose2> T_vehicle_poses() const { return T_vehicle_poses_; }

  /// Whether the azimuths of radar `index` are to be taken with the other sign.
  bool IsMirrored(std::size_t index) const { return radars_[index].is_mirrored; }

  /// A scan of radar `index`. Returns whether it is to be compared.
  bool IsDue(std::size_t index);

  /// `point_count` points of a scan of radar `index` that is due fit the map by `mirrored_fit` if
  /// their azimuths have the other sign than they are taken with, and by `fit` at best if they have
  /// not: [0, 1]. Returns whether the sign has changed.
  bool OnFits(std::size_t index, std::size_t point_count, double fit, double mirrored_fit);

  /// The vehicle is where it is supposed to be, and scans fit there: the signs are right.
  void OnConfirmed();

  /// Nothing in the map looks like what the radars see. Of a radar whose sign was changed since the
  /// pose was confirmed the other sign is tried: it may have been chosen at a wrong pose. Returns
  /// whether that of radar `index` was.
  bool TryOther(std::size_t index);

  /// The vehicle is somewhere else than was supposed: scans that were compared do not count.
  void Reset();

 private:
  struct Radar {
    bool is_mirrored = false;
    bool is_proven = true;
    int scan_count = 0;  // since one was compared
    OneSidedCusum other_fits;
  };
  AzimuthSignOptions options_;
  std::vector<Radar> radars_;
  std::vector<Pose2> T_vehicle_poses_;
};

}  // namespace dcloc
