#include "client/cli/map/survey_run.h"

#include <optional>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/map_report.h"
#include "client/cli/map/stage_line.h"
#include "client/cli/map/survey_fixes.h"
#include "client/cli/map/survey_fuse.h"
#include "client/cli/map/survey_judge.h"
#include "client/cli/map/survey_summary.h"
#include "client/trajectory/file_of_drive.h"
#include "core/mapping/drive_tracker.h"
#include "core/mapping/survey.h"

namespace dcloc::cli {
namespace {

// One command's work. Drives are read one at a time, once to track them and once to fuse them, so
// that memory does not grow with their scans.
class SurveyRun {
 public:
  explicit SurveyRun(const SurveyArguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    absl::Status status = CheckTrajectory(arguments_.trajectory, !arguments_.fix_files.empty());
    if (status.ok()) status = TrackDrives();
    if (!status.ok()) return status;
    auto fixes = ReadSurveyFixes(arguments_.fix_files, tracks_, arguments_.anchor);
    if (!fixes.ok()) return fixes.status();
    fixes_ = *std::move(fixes);
    auto survey =
        SurveyDrives(tracks_, fixes_.fixes, options_, [&](const char* stage, double share) {
          line_.Update(stage, share);
          return true;
        });
    if (!survey.ok()) return survey.status();
    survey_ = *std::move(survey);
    status = WriteMap();
    if (status.ok()) status = WritePoses();
    if (status.ok()) Report();
    return status;
  }

 private:
  absl::StatusOr<Drive> Read(const std::string& name) const {
    DriveRequest request = arguments_.request;
    request.name = name;
    return ReadDrive(arguments_.dataset, request);
  }

  absl::Status TrackDrives() {
    for (std::size_t i = 0; i < arguments_.drives.size(); ++i) {
      const absl::StatusOr<Drive> drive = Read(arguments_.drives[i]);
      if (!drive.ok()) return drive.status();
      if (absl::Status status = CheckRadarsOfScans(*drive); !status.ok()) return status;
      DriveTracker tracker(drive->name, drive->rig, tracker_options_);
      for (std::size_t k = 0; k < drive->scans.size(); ++k) {
        if (absl::Status status = tracker.Add(drive->scans[k].scan); !status.ok()) {
          return absl::Status(status.code(),
                              absl::StrCat(drive->name, ", scan ", k, ": ", status.message()));
        }
        line_.Update(
            absl::StrFormat("tracking %s (%d of %d)", drive->name, i + 1, arguments_.drives.size()),
            static_cast<double>(k + 1) / static_cast<double>(drive->scans.size()));
      }
      tracks_.push_back(tracker.Finish());
      rig_.Add(drive->name, drive->rig);
      if (arguments_.compare_truth) truths_.push_back(TruthOf(*drive, tracks_.back()));
    }
    return absl::OkStatus();
  }

  absl::Status WriteMap() {
    MapBuilderOptions options;
    options.name = arguments_.name.empty() ? arguments_.drives.front() : arguments_.name;
    options.description = absl::StrCat("dcloc map survey: ", arguments_.dataset.format, " ",
                                       absl::StrJoin(arguments_.drives, ", "));
    if (survey_.accepted_fix_count > 0) options.anchor = fixes_.anchor;
    auto builder = MapBuilder::Create(rig_.rig(), options);
    if (!builder.ok()) return builder.status();
    for (std::size_t i = 0; i < survey_.drives.size(); ++i) {
      if (!survey_.drives[i].is_in_map) continue;
      const absl::StatusOr<Drive> drive = Read(survey_.drives[i].name);
      if (!drive.ok()) return drive.status();
      absl::Status status = AddSurveyedDrive(
          *drive, tracks_[i], survey_.drives[i].T_map_nodes, rig_, *builder, [&](std::size_t done) {
            line_.Update(absl::StrCat("placing scans of ", drive->name),
                         static_cast<double>(done) / static_cast<double>(drive->scans.size()));
            return true;
          });
      if (!status.ok()) return status;
    }
    line_.Update("fusing landmarks", 0.0);
    auto bytes = builder->Build();
    if (!bytes.ok()) return bytes.status();
    if (absl::Status status = WriteFileAtomically(arguments_.out, *bytes); !status.ok()) {
      return status;
    }
    const auto map = RadarMap::FromBytes(*std::move(bytes));
    if (!map.ok()) return map.status();
    info_ = (*map)->info();
    return absl::OkStatus();
  }

  /// To the file itself, or of several drives to one each; of those in the map.
  absl::Status WritePoses() const {
    absl::Status status;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const SurveyedDrive& drive = survey_.drives[i];
      if (!drive.is_in_map) continue;
      TrajectoryArguments arguments = arguments_.trajectory;
      if (tracks_.size() > 1 && !arguments.file.empty()) {
        arguments.file = FileOfDrive(arguments.file, drive.name);
      }
      Trajectory trajectory = TrajectoryOf(tracks_[i], drive);
      trajectory.anchor = info_.anchor;
      status.Update(WriteTrajectory(arguments, trajectory));
    }
    return status;
  }

  void Report() const {
    std::optional<SurveyJudgement> judgement;
    if (arguments_.compare_truth) judgement = Judge(survey_, truths_);
    if (arguments_.json) {
      nlohmann::ordered_json json = SurveyJson(tracks_, survey_, judgement);
      json["map"] = MapInfoJson(info_);
      absl::PrintF("%s\n", json.dump(2));
    } else {
      absl::PrintF("%s\n%s", SurveyText(tracks_, survey_, judgement), MapInfoText(info_));
    }
  }

  const SurveyArguments& arguments_;
  DriveTrackerOptions tracker_options_;
  SurveyOptions options_;
  StageLine line_;
  std::vector<DriveTrack> tracks_;
  std::vector<DriveTruth> truths_;
  JoinedRig rig_;
  SurveyFixes fixes_;
  Survey survey_;
  MapInfo info_;
};

}  // namespace

absl::Status RunSurvey(const SurveyArguments& arguments) { return SurveyRun(arguments).Run(); }

}  // namespace dcloc::cli
