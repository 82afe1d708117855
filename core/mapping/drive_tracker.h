#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/map/landmark_fusion.h"
#include "core/mapping/drive_track.h"
#include "core/odometry/ego_motion.h"
#include "core/options/option_fields.h"
#include "core/radar/radar_model.h"
#include "core/radar/static_points.h"

namespace dcloc {

struct DriveTrackerOptions {
  EgoMotionOptions ego_motion;
  StaticPointsOptions static_points;
  double node_spacing_m = 10.0;  ///< driven between nodes
  /// Of each radar, scans nearer than this to the last one taken show nothing new: the vehicle
  /// stands or crawls.
  double min_move_m = 0.2;
  double min_turn_rad = 0.02;
  double cell_m = 0.4;     ///< of landmarks, as FusionOptions::cell_m
  int min_scan_count = 2;  ///< landmarks that fewer scans of a node show are clutter
};
std::span<const OptionField<DriveTrackerOptions>> FieldsOf(const DriveTrackerOptions& options);
absl::Status Validate(const DriveTrackerOptions& options);

/// Turns the scans of one drive into its track: ego-motion from Doppler and what the vehicle
/// reports, and every few metres a node with the landmarks seen there. Holds the points of one node
/// at a time.
class DriveTracker {
 public:
  /// `rig` and `options` are valid.
  DriveTracker(std::string drive_name, Rig rig, const DriveTrackerOptions& options);

  /// The next scan, by ascending stamp. InvalidArgument names what is wrong with it; the track is
  /// then as before.
  absl::Status Add(const Scan& scan);

  /// The whole track. A drive that did not move has one node; one without scans has none.
  DriveTrack Finish();

 private:
  // A scan of the node that is being made.
  struct Part {
    std::size_t scan;     // in track_.scans
    Motion motion;        // from the part before it, or from the last node
    double arc_length_m;  // driven since the drive's first scan
    std::vector<RadarPoint> points;
  };

  bool ShowsSomethingNew(std::size_t radar_index);
  void CloseNode();
  std::vector<GaussianPoint<2>> FuseParts(const Pose2& T_odometry_node) const;

  Rig rig_;
  DriveTrackerOptions options_;
  EgoMotion ego_motion_;
  DriveTrack track_;
  std::vector<Part> parts_;
  Motion since_part_;          // from the last part, or the last node, to the newest scan
  double node_begin_m_ = 0.0;  // arc length at which the node that is being made begins
  std::vector<std::optional<Pose2>> last_taken_;  // by radar
};

}  // namespace dcloc
