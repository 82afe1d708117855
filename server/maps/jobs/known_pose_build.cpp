#include "server/maps/jobs/known_pose_build.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/odometry/ego_motion.h"
#include "core/online_calibration/drive_stamps.h"
#include "core/online_calibration/learned_stamps.h"
#include "server/base/status.h"
#include "server/convert/geometry.h"
#include "server/convert/scan.h"

namespace dcloc::server {
namespace {

/// One build. The scans are read twice.
class KnownPoseBuild {
 public:
  KnownPoseBuild(const BuildRequest& request, FramedReader& spool, BuildProgress& progress)
      : request_(request), spool_(spool), progress_(progress), begin_(spool.position()) {}

  absl::StatusOr<std::vector<std::byte>> Run() {
    const absl::StatusOr<MeasuredStamps> stamps = Stamps();
    if (!stamps.ok()) return stamps.status();
    if (absl::Status status = spool_.Begin(begin_); !status.ok()) return status;
    MapBuilderOptions options = request_.options;
    options.stamp_delay_s = stamps->mean_delay_s;
    absl::StatusOr<MapBuilder> builder = MapBuilder::Create(stamps->rig, options);
    if (!builder.ok()) return builder.status();
    if (absl::Status status = AddScans(stamps->rig, *builder); !status.ok()) return status;
    if (!progress_.Tell("fusing landmarks", 0.0)) return BuildStopped();
    return builder->Build();
  }

 private:
  // How late radars stamp their scans is known after the last scan only. Scans that are not valid
  // are left to AddScans, which names them.
  absl::StatusOr<MeasuredStamps> Stamps() {
    DriveStamps stamps(request_.rig);
    if (!stamps.IsNeeded()) return MeasuredStamps{.rig = request_.rig};
    v1::StartMapBuildRequest message;
    Scan scan;
    while (progress_.Tell("measuring stamps", 0.0)) {
      const absl::StatusOr<bool> there = spool_.Next(&message);
      if (!there.ok()) return there.status();
      if (!*there) return stamps.Measured();
      if (message.scan().begins_pass()) stamps.BeginPass();
      if (convert::FromProto(message.scan().scan(), request_.rig, &scan).ok()) stamps.Add(scan);
    }
    return BuildStopped();
  }

  absl::Status AddScans(const Rig& rig, MapBuilder& builder) {
    EgoMotion ego_motion;
    v1::StartMapBuildRequest message;
    const auto scan_count = static_cast<double>(progress_.Get().scan_count());
    for (std::int64_t index = 0;; ++index) {
      if (!progress_.Tell("placing scans", static_cast<double>(index) / scan_count)) {
        return BuildStopped();
      }
      const absl::StatusOr<bool> there = spool_.Next(&message);
      if (!there.ok() || !*there) return there.status();
      if (message.scan().begins_pass() && index > 0) {
        builder.BeginPass();
        ego_motion = EgoMotion();
      }
      absl::Status status = AddScan(message.scan(), rig, ego_motion, builder);
      if (!status.ok()) return WithPrefix(absl::StrCat("scan ", index, ": "), status);
      progress_.CountScans(1);
    }
  }

  absl::Status AddScan(const v1::PosedScan& message, const Rig& rig, EgoMotion& ego_motion,
                       MapBuilder& builder) {
    absl::Status status = convert::FromProto(message.scan(), request_.rig, &scan_);
    const absl::StatusOr<Pose3> pose = convert::FromProto(message.t_map_vehicle(), "t_map_vehicle");
    if (status.ok()) status = pose.status();
    if (!status.ok()) return status;
    const EgoVelocity& velocity = ego_motion.Advance(scan_, *rig.Find(scan_.radar_id));
    return builder.Add(scan_, *pose, velocity);
  }

  const BuildRequest& request_;
  FramedReader& spool_;
  BuildProgress& progress_;
  const std::int64_t begin_;
  Scan scan_;  ///< kept for its columns' memory
};

}  // namespace

absl::StatusOr<std::vector<std::byte>> BuildAtKnownPoses(const BuildRequest& request,
                                                         FramedReader& spool,
                                                         BuildProgress& progress) {
  return KnownPoseBuild(request, spool, progress).Run();
}

}  // namespace dcloc::server
