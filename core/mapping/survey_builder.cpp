#include "core/mapping/survey_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/geometry/thinning.h"
#include "core/odometry/ego_motion.h"

namespace dcloc {
namespace {

constexpr double kScaleStep = 0.003;
constexpr double kMinFoundPart = 0.2;       // of a scale that is missing; less tells nothing
constexpr double kSignificantSigmas = 2.0;  // of a scale that is corrected
constexpr double kSystematicSigma = 2e-4;   // of a measurement: what it says at true poses

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
  tracks_.clear();
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
  rig_.Add(reader.name(), reader.rig());
  DriveTracker tracker(reader.name(), rig_.Of(reader.name(), reader.rig()), options_.tracker);
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

absl::Status SurveyBuilder::Calibrate(std::span<const SurveyFix> fixes,
                                      const CheckpointsOfRound& checkpoints) {
  for (int round = 1; round <= options_.calibration_rounds; ++round) {
    SurveyRig rig_before = rig_;
    const absl::StatusOr<bool> is_changed = CalibrateVehicles();
    if (!is_changed.ok() || !*is_changed) return is_changed.status();
    const std::size_t count_before = DriveCountInMap();
    std::vector<DriveTrack> tracks_before = std::move(tracks_);
    Survey survey_before = std::move(survey_);
    absl::Status status = Track();
    if (status.ok()) status = Place(fixes, checkpoints ? checkpoints(round) : nullptr);
    if (!status.ok()) return status;
    if (DriveCountInMap() >= count_before) continue;
    rig_ = std::move(rig_before);
    tracks_ = std::move(tracks_before);
    survey_ = std::move(survey_before);
    return absl::OkStatus();
  }
  return absl::OkStatus();
}

std::size_t SurveyBuilder::DriveCountInMap() const {
  return static_cast<std::size_t>(
      std::ranges::count(survey_.drives, true, &SurveyedDrive::is_in_map));
}

// Whether the radars are known to be other than before.
absl::StatusOr<bool> SurveyBuilder::CalibrateVehicles() {
  bool is_changed = false;
  for (const SurveyVehicle& vehicle : rig_.Vehicles()) {
    const absl::StatusOr<bool> changed = CalibrateVehicle(vehicle);
    if (!changed.ok()) return changed.status();
    is_changed = is_changed || *changed;
  }
  return is_changed;
}

absl::StatusOr<bool> SurveyBuilder::CalibrateVehicle(const SurveyVehicle& vehicle) {
  absl::StatusOr<Calibrator> calibrator = Calibrator::Create(vehicle.rig, options_.calibrator);
  if (!calibrator.ok()) return calibrator.status();
  std::vector<std::size_t> drives;
  std::size_t scan_count = 0;
  for (std::size_t i = 0; i < survey_.drives.size(); ++i) {
    if (!survey_.drives[i].is_in_map || !vehicle.Drove(survey_.drives[i].name)) continue;
    drives.push_back(i);
    scan_count += tracks_[i].scans.size();
  }
  const std::size_t step = StepToKeep(options_.max_calibration_scans, scan_count);
  std::map<std::string, std::size_t> seen_counts;  // by radar: each shall have its share
  for (const std::size_t drive : drives) {
    absl::Status status =
        ReadPlaced(drive, "calibrating by",
                   [&](const Scan& scan, const Pose3& T_map_vehicle, const EgoVelocity& velocity) {
                     if (seen_counts[scan.radar_id]++ % step != 0) return absl::OkStatus();
                     return calibrator->Add("map", scan, T_map_vehicle, velocity);
                   });
    if (!status.ok()) return status;
  }
  absl::Status status;
  absl::StatusOr<Calibration> found =
      calibrator->Estimate([&](std::size_t done, std::size_t total) {
        const double share = static_cast<double>(done) / static_cast<double>(total);
        if (!progress_("estimating mounts and clocks", share)) status = Stopped();
      });
  if (!status.ok()) return status;
  if (absl::IsFailedPrecondition(found.status())) return false;  // it sees nothing twice
  if (!found.ok()) return found.status();
  return rig_.Learn(*std::move(found));
}

// The landmarks of a map follow its poses, and returns are assigned to them. So a measurement finds
// a part of what is missing, and another one at a known scale beside it tells which part.
absl::Status SurveyBuilder::CorrectScale() {
  scale_correction_.reset();
  if (survey_.accepted_fix_count > 0 || rig_.Known().MeasuresElevation()) return absl::OkStatus();
  const absl::StatusOr<std::optional<ScalarEstimate>> here = MeasureScale();
  if (!here.ok() || !*here) return here.status();
  const std::vector<SurveyedDrive> drives_here = survey_.drives;
  Rescale(1.0 + kScaleStep);
  const absl::StatusOr<std::optional<ScalarEstimate>> beside = MeasureScale();
  survey_.drives = drives_here;
  if (!beside.ok() || !*beside) return beside.status();
  const double found_part = ((*here)->value - (*beside)->value) / kScaleStep;
  if (found_part < kMinFoundPart) return absl::OkStatus();
  const bool is_significant =
      std::abs((*here)->value) > kSignificantSigmas * std::sqrt((*here)->variance);
  scale_correction_ = {
      .value = is_significant ? (*here)->value / found_part : 0.0,
      .variance = ((*here)->variance + std::pow(kSystematicSigma, 2)) / std::pow(found_part, 2)};
  Rescale(1.0 + scale_correction_->value);
  return absl::OkStatus();
}

absl::StatusOr<std::optional<ScalarEstimate>> SurveyBuilder::MeasureScale() {
  absl::StatusOr<std::vector<std::byte>> bytes = Fuse({.name = "scale"});
  if (absl::IsFailedPrecondition(bytes.status())) return std::nullopt;  // without a landmark
  if (!bytes.ok()) return bytes.status();
  const auto map = RadarMap::FromBytes(*std::move(bytes));
  if (!map.ok()) return map.status();
  ScaleEstimator estimator(**map, options_.scale);
  const Rig rig = rig_.Known();
  for (std::size_t i = 0; i < survey_.drives.size(); ++i) {
    if (!survey_.drives[i].is_in_map) continue;
    absl::Status status = ReadPlaced(
        i, "measuring the scale by",
        [&](const Scan& scan, const Pose3& T_map_vehicle, const EgoVelocity& velocity) {
          const RadarModel& radar = *rig.Find(scan.radar_id);
          estimator.Add(StaticPoints(scan, radar, velocity, options_.tracker.static_points),
                        scan.stamp, T_map_vehicle, MountAtStamp(radar, velocity));
          return absl::OkStatus();
        });
    if (!status.ok()) return status;
    estimator.EndDrive();
  }
  return estimator.Estimate();
}

void SurveyBuilder::Rescale(double factor) {
  for (SurveyedDrive& drive : survey_.drives) {
    if (!drive.is_in_map) continue;
    for (Pose2& T_map_node : drive.T_map_nodes) T_map_node.translation_m *= factor;
  }
}

absl::StatusOr<std::vector<std::byte>> SurveyBuilder::Fuse(const MapBuilderOptions& options) {
  absl::StatusOr<MapBuilder> builder = MapBuilder::Create(rig_.Known(), options);
  if (!builder.ok()) return builder.status();
  for (std::size_t i = 0; i < survey_.drives.size(); ++i) {
    if (!survey_.drives[i].is_in_map) continue;
    builder->BeginPass();
    absl::Status status =
        ReadPlaced(i, "placing scans of",
                   [&](const Scan& scan, const Pose3& T_map_vehicle, const EgoVelocity& velocity) {
                     return builder->Add(scan, T_map_vehicle, velocity);
                   });
    if (!status.ok()) return status;
  }
  if (!progress_("fusing landmarks", 0.0)) return Stopped();
  return builder->Build();
}

// Gives `take` each scan of a drive with the pose and velocity of the vehicle; its radar is named
// as in the joined rig.
absl::Status SurveyBuilder::ReadPlaced(std::size_t index, const char* doing, const TakeScan& take) {
  const auto drive = source_.Open(index);
  if (!drive.ok()) return drive.status();
  DriveReader& reader = **drive;
  const std::string stage = absl::StrCat(doing, " ", reader.name());
  const DriveTrack& track = tracks_[index];
  const Rig rig = rig_.Of(reader.name(), reader.rig());
  EgoMotion ego_motion;
  for (std::size_t k = 0;; ++k) {
    const absl::StatusOr<const Scan*> next = reader.Next();
    if (!next.ok()) return next.status();
    if (*next == nullptr) return absl::OkStatus();
    Scan scan = **next;
    const RadarModel& described = *reader.rig().Find(scan.radar_id);
    const EgoVelocity& velocity = ego_motion.Advance(scan, *rig.Find(scan.radar_id));
    scan.radar_id = rig_.IdOf(reader.name(), described);
    const Pose3 T_map_vehicle =
        Embed(PlaceScan(track, survey_.drives[index].T_map_nodes, track.scans[k]));
    if (absl::Status status = take(scan, T_map_vehicle, velocity); !status.ok()) {
      return NamingScan(
          reader.name(), k,
          absl::Status(status.code(), absl::StrCat(described.id, ": ", status.message())));
    }
    if (!progress_(stage.c_str(), Share(k + 1, reader))) return Stopped();
  }
}

}  // namespace dcloc
