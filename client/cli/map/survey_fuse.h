#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/datasets/drive.h"
#include "core/map/map_builder.h"
#include "core/mapping/drive_track.h"

namespace dcloc::cli {

/// The radars of several drives in one rig. A radar that two drives describe alike is one; of one
/// id described differently, the later drive's is called "ID@DRIVE".
class JoinedRig {
 public:
  void Add(const std::string& drive, const Rig& rig);

  const Rig& rig() const { return rig_; }
  /// The id in the joined rig of a radar of a drive that was added.
  std::string IdOf(const std::string& drive, const RadarModel& radar) const;

 private:
  Rig rig_;
};

/// Adds the scans of a surveyed drive to a map as a pass of its own, at the poses that the survey
/// found for them. `progress` receives the number of scans done and says whether to go on. Errors
/// name the drive and the scan; Cancelled.
absl::Status AddSurveyedDrive(const Drive& drive, const DriveTrack& track,
                              std::span<const Pose2> T_map_nodes, const JoinedRig& rig,
                              MapBuilder& builder,
                              const std::function<bool(std::size_t)>& progress);

}  // namespace dcloc::cli
