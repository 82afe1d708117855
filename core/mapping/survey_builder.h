#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/map/map_builder.h"
#include "core/mapping/drive_source.h"
#include "core/mapping/drive_tracker.h"
#include "core/mapping/joined_rig.h"
#include "core/mapping/survey.h"

namespace dcloc {

struct SurveyBuilderOptions {
  DriveTrackerOptions tracker;
  SurveyOptions survey;
};

/// Makes a map of drives without poses: tracks them, places them, and fuses what they saw. Drives
/// are read one at a time, once to track and once to fuse, so that memory does not grow with their
/// scans. To be called in the order of the declarations. Errors name the drive and the scan;
/// Cancelled when `progress` says so.
class SurveyBuilder {
 public:
  /// `source` and what `progress` refers to outlive it.
  SurveyBuilder(DriveSource& source, SurveyProgress progress,
                const SurveyBuilderOptions& options = {});

  /// Reads all drives for the first time.
  absl::Status Track();
  const std::vector<DriveTrack>& tracks() const { return tracks_; }

  /// `SurveyDrives` of the tracks.
  absl::Status Place(std::span<const SurveyFix> fixes,
                     SurveyCheckpointStore* checkpoints = nullptr);
  const Survey& survey() const { return survey_; }

  /// Reads those that are in the map again; gives the map file's bytes. Each drive is a pass.
  absl::StatusOr<std::vector<std::byte>> Fuse(const MapBuilderOptions& options);

 private:
  absl::Status TrackDrive(std::size_t drive);
  absl::Status FuseDrive(std::size_t drive, MapBuilder& builder);

  DriveSource& source_;
  SurveyProgress progress_;
  SurveyBuilderOptions options_;
  std::vector<DriveTrack> tracks_;
  JoinedRig rig_;
  Survey survey_;
};

}  // namespace dcloc
