#pragma once

#include <memory>

#include "core/odometry/ego_motion.h"
#include "core/online_calibration/learned_stamps.h"
#include "core/online_calibration/radar_delays.h"
#include "core/radar/radar_model.h"
#include "core/radar/scan.h"

namespace dcloc {

/// Measures how late the radars that make a map stamp their scans, by all scans of its drives.
class DriveStamps {
 public:
  explicit DriveStamps(Rig described, const LearnedStampOptions& options = {});

  /// Whether there is anything to measure: a rig that is described to the last digit is not
  /// doubted.
  bool IsNeeded() const;

  /// The next scan of the drive, of a radar of the rig. Its stamp is not before the last one's.
  void Add(const Scan& scan);

  /// The scans that follow are another drive's.
  void BeginPass();

  /// See MeasuredStamps.
  MeasuredStamps Measured();

 private:
  LearnedStampOptions options_;
  std::shared_ptr<const Rig> described_;  // where ego-motion may point to
  RadarDelays delays_;
  EgoMotion ego_motion_;
  EgoVelocityWorkspace workspace_;
};

}  // namespace dcloc
