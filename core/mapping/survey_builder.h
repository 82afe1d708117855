#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/calibration/calibrator.h"
#include "core/map/map_builder.h"
#include "core/mapping/drive_source.h"
#include "core/mapping/drive_tracker.h"
#include "core/mapping/scale_estimator.h"
#include "core/mapping/survey.h"
#include "core/mapping/survey_rig.h"

namespace dcloc {

struct SurveyBuilderOptions {
  DriveTrackerOptions tracker;
  SurveyOptions survey;
  CalibratorOptions calibrator;
  /// Of a vehicle, as many scans at most are what it is calibrated by, evenly among all.
  std::size_t max_calibration_scans = 20'000;
  int calibration_rounds = 3;  ///< at most
  ScaleEstimatorOptions scale;
};

/// Makes a map of drives without poses: tracks them, places them, and fuses what they saw. Drives
/// are read one at a time, each time they are tracked, calibrated by, and fused, so that memory
/// does not grow with their scans. To be called in the order of the declarations. Errors name the
/// drive and the scan; Cancelled when `progress` says so.
class SurveyBuilder {
 public:
  /// `source` and what `progress` refers to outlive it.
  SurveyBuilder(DriveSource& source, SurveyProgress progress,
                const SurveyBuilderOptions& options = {});

  /// Reads all drives. What an earlier call found is forgotten.
  absl::Status Track();
  const std::vector<DriveTrack>& tracks() const { return tracks_; }

  /// `SurveyDrives` of the tracks.
  absl::Status Place(std::span<const SurveyFix> fixes,
                     SurveyCheckpointStore* checkpoints = nullptr);
  const Survey& survey() const { return survey_; }

  /// Where the survey that follows a calibration keeps its checkpoint; rounds count from 1.
  using CheckpointsOfRound = std::function<SurveyCheckpointStore*(int round)>;

  /// Estimates what is wrong with the radars of each vehicle (`Calibrator`) from the drives in the
  /// map, and tracks and places all drives with what was found: for `calibration_rounds`, or until
  /// nothing more is found. Vehicles that see nothing twice stay as they are described. So do all
  /// from the round on that would leave a drive out of the map.
  absl::Status Calibrate(std::span<const SurveyFix> fixes,
                         const CheckpointsOfRound& checkpoints = nullptr);
  /// What was found of each radar, named as in the joined rig; empty before `Calibrate`.
  std::span<const RadarCalibration> calibrations() const { return rig_.calibrations(); }

  /// Moves the poses apart, or together, by what slant ranges say of their scale, where that is
  /// significant (`ScaleEstimator`). Drives that fixes have placed keep the scale of the fixes, and
  /// radars that measure elevation know it.
  absl::Status CorrectScale();
  /// By which share slant ranges say that the poses lay too near one another, and how uncertain the
  /// scale is now; nothing where they say nothing.
  const std::optional<ScalarEstimate>& scale_correction() const { return scale_correction_; }

  /// Reads those that are in the map again; gives the map file's bytes. Each drive is a pass.
  absl::StatusOr<std::vector<std::byte>> Fuse(const MapBuilderOptions& options);

 private:
  absl::Status TrackDrive(std::size_t drive);
  using TakeScan = std::function<absl::Status(const Scan&, const Pose3&, const EgoVelocity&)>;
  absl::Status ReadPlaced(std::size_t drive, const char* doing, const TakeScan& take);
  std::size_t DriveCountInMap() const;
  absl::StatusOr<std::optional<ScalarEstimate>> MeasureScale();
  void Rescale(double factor);
  absl::StatusOr<bool> CalibrateVehicles();
  absl::StatusOr<bool> CalibrateVehicle(const SurveyVehicle& vehicle);

  DriveSource& source_;
  SurveyProgress progress_;
  SurveyBuilderOptions options_;
  std::vector<DriveTrack> tracks_;
  SurveyRig rig_;
  Survey survey_;
  std::optional<ScalarEstimate> scale_correction_;
};

}  // namespace dcloc
