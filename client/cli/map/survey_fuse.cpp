#include "client/cli/map/survey_fuse.h"

#include "absl/strings/str_cat.h"
#include "core/odometry/ego_motion.h"

namespace dcloc::cli {
namespace {

// All that a map made with it depends on.
bool IsAlike(const RadarModel& a, const RadarModel& b) {
  return a.T_vehicle_radar.translation_m == b.T_vehicle_radar.translation_m &&
         a.T_vehicle_radar.rotation.coeffs() == b.T_vehicle_radar.rotation.coeffs() &&
         a.beta_s == b.beta_s && a.range_bias_m == b.range_bias_m &&
         a.time_offset_s == b.time_offset_s && a.range_sigma_m == b.range_sigma_m &&
         a.azimuth_sigma_rad == b.azimuth_sigma_rad &&
         a.elevation_sigma_rad == b.elevation_sigma_rad && a.has_elevation == b.has_elevation &&
         a.range_rate_sigma_mps == b.range_rate_sigma_mps &&
         a.unambiguous_range_rate_mps == b.unambiguous_range_rate_mps;
}

}  // namespace

void JoinedRig::Add(const std::string& drive, const Rig& rig) {
  for (const RadarModel& radar : rig.radars) {
    const std::string id = IdOf(drive, radar);
    if (rig_.Find(id) != nullptr) continue;
    rig_.radars.push_back(radar);
    rig_.radars.back().id = id;
  }
}

std::string JoinedRig::IdOf(const std::string& drive, const RadarModel& radar) const {
  const RadarModel* const known = rig_.Find(radar.id);
  if (known == nullptr || IsAlike(*known, radar)) return radar.id;
  return absl::StrCat(radar.id, "@", drive);
}

absl::Status AddSurveyedDrive(const Drive& drive, const DriveTrack& track,
                              std::span<const Pose2> T_map_nodes, const JoinedRig& rig,
                              MapBuilder& builder,
                              const std::function<bool(std::size_t)>& progress) {
  builder.BeginPass();
  EgoMotion ego_motion;
  for (std::size_t i = 0; i < drive.scans.size(); ++i) {
    Scan scan = drive.scans[i].scan;
    const RadarModel& radar = *drive.rig.Find(scan.radar_id);
    const EgoVelocity& velocity = ego_motion.Advance(scan, radar);
    scan.radar_id = rig.IdOf(drive.name, radar);
    const Pose3 T_map_vehicle = Embed(PlaceScan(track, T_map_nodes, track.scans[i]));
    if (absl::Status status = builder.Add(scan, T_map_vehicle, velocity); !status.ok()) {
      return absl::Status(status.code(), absl::StrCat(drive.name, ", scan ", i, " of ", radar.id,
                                                      ": ", status.message()));
    }
    if (!progress(i + 1)) return absl::CancelledError("the survey was stopped");
  }
  return absl::OkStatus();
}

}  // namespace dcloc::cli
