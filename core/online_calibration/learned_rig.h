#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/odometry/rig_knowledge.h"
#include "core/odometry/source_fault.h"
#include "core/online_calibration/learned_stamps.h"
#include "core/online_calibration/mount_yaw_estimator.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// When what was learned of a rig goes before its description.
struct LearnedRigOptions {
  MountYawOptions mount_yaw;
  LearnedStampOptions stamps;
  /// The smallest correction of a mount's yaw. On recordings, whose azimuths have errors of their
  /// own, the estimate errs by up to a degree and a half.
  double min_correction_rad = 2.0 * kRadPerDeg;
  double correction_sigmas = 4.0;  ///< the smallest one in standard deviations of the estimate
  int min_reading_count = 4;       ///< readings that a correction needs
  /// What an earlier session found is no more certain than this, and counts as one reading less
  /// than are needed: the first scan that agrees confirms it.
  double known_sigma_rad = 0.5 * kRadPerDeg;
  /// The deviation of a corrected mount is no less, nor than described.
  double corrected_sigma_rad = 0.2 * kRadPerDeg;
  /// A mount that is corrected by more than this is reported as faulty.
  double suspected_rad = 2.0 * kRadPerDeg;
  /// Scans of a mount that is off by more than this are not used: its description must be wrong
  /// altogether.
  double max_correction_rad = 20.0 * kRadPerDeg;
  /// A radar whose ranges are longer or shorter than described by more than this is reported, too.
  double suspected_range_m = 0.5;
};
static_assert(LearnedRigOptions{}.max_correction_rad <= kMaxKnownMountYawError_rad);
std::span<const OptionField<LearnedRigOptions>> FieldsOf(const LearnedRigOptions& options);
absl::Status Validate(const LearnedRigOptions& options);

/// The radars of a vehicle as they were described, corrected by what their scans measure.
class LearnedRig {
 public:
  LearnedRig(Rig described, const LearnedRigOptions& options);

  /// An earlier session found this. What says nothing of a radar of the rig is ignored.
  void Restore(const RigKnowledge& known);

  /// Adds what was learned of the mounts.
  void AddTo(RigKnowledge& known) const;

  /// As corrected so far; it has the described radars, in their order.
  const Rig& rig() const { return rig_; }

  /// Of a radar of the rig.
  std::size_t IndexOf(std::string_view radar_id) const { return rig_.IndexOf(radar_id); }

  /// A scan of radar `index`, of a vehicle that moves with `velocity`, whose yaw rate others
  /// than radars say. Returns whether its mount has been corrected.
  bool OnScan(Stamp stamp, std::size_t index, const Scan& scan, const EgoVelocity& velocity);

  /// The stamps of the radars that made the map were known, and late by `map_delay_s` on average.
  /// So those of these radars are learned too. In a map whose radars were as late as these, to
  /// correct these alone would misplace them.
  void BeginToLearnStamps(double map_delay_s);

  /// A scan of radar `index`; `is_sound`: wheels, gyroscope and Doppler are. Returns by how
  /// much the time offset of any radar has changed, at most [s].
  double LearnStamps(Stamp stamp, std::size_t index, const Scan& scan, bool is_sound);

  /// The ranges of radar `index` are longer than described by so much, if that is known.
  void CorrectRange(std::size_t index, const std::optional<ScalarEstimate>& bias_error_m);

  /// kNone, or kMount where a radar looks elsewhere than described, or measures other ranges.
  SourceFault FaultOf(std::size_t index, Stamp stamp) const;

  /// Whether the radar's targets lie where its mount, described or corrected, says, as far as is
  /// known at `stamp`.
  bool IsUsable(std::size_t index, Stamp stamp) const;

  /// By how much the radar looks further to the left than described.
  const ScalarEstimate& mount_yaw_error(std::size_t index) const {
    return learned_[index].mount_yaw.error();
  }

 private:
  struct Learned {
    MountYawEstimator mount_yaw;
    double applied_rad = 0.0;
  };
  bool Correct(std::size_t index);
  void ApplyStamps();

  LearnedRigOptions options_;
  Rig described_;
  Rig rig_;
  std::vector<Learned> learned_;
  LearnedStamps stamps_;
  MountYawWorkspace workspace_;
};

}  // namespace dcloc
