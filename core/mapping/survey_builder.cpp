#include "core/mapping/survey_builder.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/odometry/ego_motion.h"

namespace dcloc {
namespace {

absl::Status Stopped() { return absl::CancelledError("the survey was stopped"); }

absl::Status NamingScan(const std::string& drive, std::size_t scan, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(drive, ", scan ", scan, ": ", status.message()));
}

double Share(std::size_t done, const DriveReader& drive) {
  return static_cast<double>(done) / static_cast<double>(drive.scan_count());
}

}  // namespace

SurveyBuilder::SurveyBuilder(DriveSource& source, SurveyProgress progress,
                             const SurveyBuilderOptions& options)
    : source_(source), progress_(std::move(progress)), options_(options) {}

absl::Status SurveyBuilder::Track() {
  for (std::size_t i = 0; i < source_.drive_count(); ++i) {
    if (absl::Status status = TrackDrive(i); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status SurveyBuilder::TrackDrive(std::size_t index) {
  const auto drive = source_.Open(index);
  if (!drive.ok()) return drive.status();
  DriveReader& reader = **drive;
  const std::string stage =
      absl::StrCat("tracking ", reader.name(), " (", index + 1, " of ", source_.drive_count(), ")");
  DriveTracker tracker(reader.name(), reader.rig(), options_.tracker);
  for (std::size_t k = 0;; ++k) {
    const absl::StatusOr<const Scan*> scan = reader.Next();
    if (!scan.ok()) return scan.status();
    if (*scan == nullptr) break;
    if (absl::Status status = tracker.Add(**scan); !status.ok()) {
      return NamingScan(reader.name(), k, status);
    }
    if (!progress_(stage.c_str(), Share(k + 1, reader))) return Stopped();
  }
  tracks_.push_back(tracker.Finish());
  rig_.Add(reader.name(), reader.rig());
  return absl::OkStatus();
}

absl::Status SurveyBuilder::Place(std::span<const SurveyFix> fixes,
                                  SurveyCheckpointStore* checkpoints) {
  absl::StatusOr<Survey> survey =
      SurveyDrives(tracks_, fixes, options_.survey, progress_, checkpoints);
  if (!survey.ok()) return survey.status();
  survey_ = *std::move(survey);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::byte>> SurveyBuilder::Fuse(const MapBuilderOptions& options) {
  absl::StatusOr<MapBuilder> builder = MapBuilder::Create(rig_.rig(), options);
  if (!builder.ok()) return builder.status();
  for (std::size_t i = 0; i < survey_.drives.size(); ++i) {
    if (!survey_.drives[i].is_in_map) continue;
    if (absl::Status status = FuseDrive(i, *builder); !status.ok()) return status;
  }
  if (!progress_("fusing landmarks", 0.0)) return Stopped();
  return builder->Build();
}

absl::Status SurveyBuilder::FuseDrive(std::size_t index, MapBuilder& builder) {
  const auto drive = source_.Open(index);
  if (!drive.ok()) return drive.status();
  DriveReader& reader = **drive;
  const std::string stage = absl::StrCat("placing scans of ", reader.name());
  const DriveTrack& track = tracks_[index];
  builder.BeginPass();
  EgoMotion ego_motion;
  for (std::size_t k = 0;; ++k) {
    const absl::StatusOr<const Scan*> next = reader.Next();
    if (!next.ok()) return next.status();
    if (*next == nullptr) return absl::OkStatus();
    Scan scan = **next;
    const RadarModel& radar = *reader.rig().Find(scan.radar_id);
    const EgoVelocity& velocity = ego_motion.Advance(scan, radar);
    scan.radar_id = rig_.IdOf(reader.name(), radar);
    const Pose3 T_map_vehicle =
        Embed(PlaceScan(track, survey_.drives[index].T_map_nodes, track.scans[k]));
    if (absl::Status status = builder.Add(scan, T_map_vehicle, velocity); !status.ok()) {
      return NamingScan(
          reader.name(), k,
          absl::Status(status.code(), absl::StrCat(radar.id, ": ", status.message())));
    }
    if (!progress_(stage.c_str(), Share(k + 1, reader))) return Stopped();
  }
}

}  // namespace dcloc
