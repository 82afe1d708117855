#include "client/cli/map/survey_run.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/calibration_report.h"
#include "client/cli/common/stage_line.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/dataset_drives.h"
#include "client/cli/map/map_files.h"
#include "client/cli/map/map_report.h"
#include "client/cli/map/survey_checkpoint_file.h"
#include "client/cli/map/survey_fixes.h"
#include "client/cli/map/survey_judge.h"
#include "client/cli/map/survey_page.h"
#include "client/cli/map/survey_summary.h"
#include "client/trajectory/file_of_drive.h"
#include "core/mapping/survey_builder.h"

namespace dcloc::cli {
namespace {

SurveyBuilderOptions OptionsOf(const SurveyArguments& arguments) {
  SurveyBuilderOptions options;
  options.calibrator = cli::OptionsOf(arguments.keep, options.calibrator);
  return options;
}

// One command's work.
class SurveyRun {
 public:
  explicit SurveyRun(const SurveyArguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    absl::Status status = CheckTrajectory(arguments_.trajectory, !arguments_.fix_files.empty());
    status.Update(CheckFolders(
        {arguments_.out, arguments_.report, arguments_.checkpoint, arguments_.rig_out}));
    if (status.ok()) status = builder_.Track();
    if (!status.ok()) return status;
    auto fixes = ReadSurveyFixes(arguments_.fix_files, builder_.tracks(), arguments_.anchor);
    if (!fixes.ok()) return fixes.status();
    status = builder_.Place(fixes->fixes, checkpoints_.OfRound(0));
    if (status.ok() && !arguments_.no_calibration) {
      status =
          builder_.Calibrate(fixes->fixes, [&](int round) { return checkpoints_.OfRound(round); });
    }
    if (status.ok()) status = builder_.CorrectScale();
    if (status.ok()) status = WriteMap(fixes->anchor);
    if (status.ok()) status = WriteRig();
    if (status.ok()) status = WritePoses();
    if (status.ok()) status = WritePage();
    if (!status.ok()) return status;
    checkpoints_.Remove();
    Report();
    return absl::OkStatus();
  }

 private:
  absl::Status WriteMap(const std::optional<GeodeticAnchor>& anchor) {
    MapBuilderOptions options;
    options.name = arguments_.name.empty() ? arguments_.drives.front() : arguments_.name;
    options.description = absl::StrCat("dcloc map survey: ", arguments_.dataset.format, " ",
                                       absl::StrJoin(arguments_.drives, ", "));
    if (builder_.survey().accepted_fix_count > 0) options.anchor = anchor;
    auto bytes = builder_.Fuse(options);
    if (!bytes.ok()) return bytes.status();
    if (absl::Status status = WriteFileAtomically(arguments_.out, *bytes); !status.ok()) {
      return status;
    }
    const auto map = RadarMap::FromBytes(*std::move(bytes));
    if (!map.ok()) return map.status();
    info_ = (*map)->info();
    return absl::OkStatus();
  }

  absl::Status WriteRig() const {
    if (arguments_.rig_out.empty()) return absl::OkStatus();
    const std::string text = RigFileJson(builder_.calibrations()).dump(2) + "\n";
    return WriteFileAtomically(arguments_.rig_out, std::as_bytes(std::span<const char>(text)));
  }

  /// To the file itself, or of several drives to one each; of those in the map.
  absl::Status WritePoses() const {
    absl::Status status;
    const std::vector<DriveTrack>& tracks = builder_.tracks();
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const SurveyedDrive& drive = builder_.survey().drives[i];
      if (!drive.is_in_map) continue;
      TrajectoryArguments arguments = arguments_.trajectory;
      if (tracks.size() > 1 && !arguments.file.empty()) {
        arguments.file = FileOfDrive(arguments.file, drive.name);
      }
      Trajectory trajectory = TrajectoryOf(tracks[i], drive);
      trajectory.anchor = info_.anchor;
      status.Update(WriteTrajectory(arguments, trajectory));
    }
    return status;
  }

  absl::Status WritePage() const {
    if (arguments_.report.empty()) return absl::OkStatus();
    const std::string page = SurveyHtml(builder_);
    return WriteFileAtomically(arguments_.report, std::as_bytes(std::span(page)));
  }

  void Remember(std::size_t index, const Drive& drive) {
    if (!arguments_.compare_truth || index < references_.size()) return;
    std::vector<TrajectoryPose>& reference = references_.emplace_back();
    for (const DriveScan& entry : drive.scans) {
      reference.push_back({entry.scan.stamp, entry.T_map_vehicle});
    }
  }

  SurveyJudgement Compared() const {
    std::vector<DriveTruth> truths;
    for (std::size_t i = 0; i < builder_.tracks().size(); ++i) {
      truths.push_back(TruthOf(references_[i], builder_.tracks()[i]));
    }
    return Judge(builder_.survey(), truths);
  }

  void Report() const {
    std::optional<SurveyJudgement> judgement;
    if (arguments_.compare_truth) judgement = Compared();
    if (arguments_.json) {
      nlohmann::ordered_json json = SurveyJson(builder_, judgement);
      json["map"] = MapInfoJson(info_);
      absl::PrintF("%s\n", json.dump(2));
    } else {
      absl::PrintF("%s\n%s", SurveyText(builder_, judgement), MapInfoText(info_));
    }
  }

  const SurveyArguments& arguments_;
  SurveyCheckpointFiles checkpoints_{arguments_.checkpoint};
  StageLine line_;
  std::vector<std::vector<TrajectoryPose>> references_;  ///< of the drives, to be compared with
  DatasetDrives source_{arguments_.dataset, arguments_.request, arguments_.drives,
                        [this](std::size_t index, const Drive& drive) { Remember(index, drive); }};
  SurveyBuilder builder_{source_,
                         [this](const char* stage, double share) {
                           line_.Update(stage, share);
                           return true;
                         },
                         OptionsOf(arguments_)};
  MapInfo info_;
};

}  // namespace

absl::Status RunSurvey(const SurveyArguments& arguments) { return SurveyRun(arguments).Run(); }

}  // namespace dcloc::cli
