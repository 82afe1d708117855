#include "core/versions/update_builder.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "core/versions/judged_version.h"
#include "core/versions/street_segments.h"

namespace dcloc {
namespace {

/// Drives whose radars are mounted alike are of one vehicle, as far as a data set tells.
std::string VehicleOf(const Rig& rig) {
  std::string text;
  for (const RadarModel& radar : rig.radars) {
    const Eigen::Vector3d& t = radar.T_vehicle_radar.translation_m;
    absl::StrAppendFormat(&text, "%s(%.4f,%.4f,%.4f,%.5f)", radar.id, t.x(), t.y(), t.z(),
                          Yaw(radar.T_vehicle_radar.rotation));
  }
  return text;
}

absl::Status Named(const std::string& drive, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(drive, ": ", status.message()));
}

/// One update's work.
class UpdateBuilder {
 public:
  UpdateBuilder(const EditableMap& base, const UpdateDrives& drives,
                const MapUpdateOptions& options, const UpdateProgress& progress)
      : base_(base), drives_(drives), options_(options), progress_(progress) {}

  absl::StatusOr<JudgedUpdate> Run() {
    absl::Status status = PlaceAll();
    if (status.ok()) status = CheckUse();
    if (status.ok()) status = Tell("updating the map", 0.0);
    if (!status.ok()) return status;
    auto update = UpdateMap(base_, result_.passes, options_);
    if (!update.ok()) return update.status();
    result_.update = *std::move(update);
    for (PlacedPass& pass : result_.passes) {
      for (PlacedScan& scan : pass.scans) scan.points = {};
    }
    if (status = Tell("judging the new version", 0.0); !status.ok()) return status;
    auto judged = JudgeVersion(base_, result_.update, held_out_rig_, held_out_scans_);
    if (!judged.ok()) return Named(result_.held_out, judged.status());
    Take(*std::move(judged));
    return std::move(result_);
  }

 private:
  void Take(JudgedVersion version) {
    const StreetSegments keyframes(result_.update.map, UpdateGateOptions{}.segment_m);
    const auto is_kept = [&](const LandmarkHistory& landmark) {
      return version.is_kept[keyframes.KeyframeAt((landmark.p_map_m - base_.Origin_m()).head<2>())];
    };
    for (LandmarkHistory& landmark : result_.update.known) {
      if (version.has_only_new_streets) landmark.fate = LandmarkFate::kKept;
    }
    for (LandmarkHistory& landmark : result_.update.found) {
      if (!is_kept(landmark)) landmark.fate = LandmarkFate::kUnproven;
    }
    if (version.has_only_new_streets) result_.update.refined_count = 0;
    const std::size_t removed = result_.update.map.keyframes.size() - version.map.keyframes.size();
    const double removed_m = static_cast<double>(removed) * options_.new_streets.keyframe_spacing_m;
    result_.update.new_streets.joined_m -= removed_m;
    result_.update.map = std::move(version.map);
    result_.update.map.info.length_m -= removed_m;
    result_.has_only_new_streets = version.has_only_new_streets;
    result_.gate = std::move(version.evaluation);
  }

  absl::Status PlaceAll() {
    auto bytes = ToMapBytes(base_);
    if (!bytes.ok()) return bytes.status();
    auto map = RadarMap::FromBytes(*std::move(bytes));
    if (!map.ok()) return map.status();
    map_ = *std::move(map);
    for (std::size_t drive = 0; drive < drives_.source.drive_count(); ++drive) {
      auto reader = drives_.source.Open(drive);
      if (!reader.ok()) return reader.status();
      absl::Status status = drive == drives_.held_out ? HoldOut(**reader) : Place(drive, **reader);
      if (!status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status HoldOut(DriveReader& drive) {
    result_.held_out = drive.name();
    held_out_rig_ = drive.rig();
    return ForEachScan(drive, "reading",
                       [&](const Scan& scan) { held_out_scans_.push_back(scan); });
  }

  absl::Status Place(std::size_t number, DriveReader& drive) {
    const std::string vehicle =
        drives_.vehicles.empty() ? VehicleOf(drive.rig()) : drives_.vehicles[number];
    auto placer = PassPlacer::Create(map_, drive.name(), vehicle, drive.rig());
    if (!placer.ok()) return Named(drive.name(), placer.status());
    absl::Status status =
        ForEachScan(drive, "localizing", [&](const Scan& scan) { placer->Add(scan); });
    if (!status.ok()) return status;
    PlacedPass pass = std::move(*placer).Finish();
    result_.faults.push_back(FaultOf(pass));
    if (!result_.faults.back().empty()) {
      for (PlacedScan& scan : pass.scans) scan.is_good = false;
    }
    result_.passes.push_back(std::move(pass));
    return absl::OkStatus();
  }

  template <typename Visit>
  absl::Status ForEachScan(DriveReader& drive, const char* stage, const Visit& visit) {
    for (std::size_t count = 1;; ++count) {
      const absl::StatusOr<const Scan*> scan = drive.Next();
      if (!scan.ok()) return scan.status();
      if (*scan == nullptr) return absl::OkStatus();
      visit(**scan);
      absl::Status status =
          Tell(absl::StrCat(stage, " ", drive.name()),
               static_cast<double>(count) / static_cast<double>(drive.scan_count()));
      if (!status.ok()) return status;
    }
  }

  absl::Status CheckUse() const {
    const auto useful = std::ranges::count(result_.faults, std::string());
    if (useful >= 2) return absl::OkStatus();
    std::vector<std::string> why;
    for (std::size_t i = 0; i < result_.passes.size(); ++i) {
      if (result_.faults[i].empty()) continue;
      why.push_back(absl::StrCat(result_.passes[i].name, ": ", result_.faults[i]));
    }
    return absl::FailedPreconditionError(absl::StrCat("two drives must agree on a change, and ",
                                                      useful, " is of use. ",
                                                      absl::StrJoin(why, "; ")));
  }

  absl::Status Tell(const std::string& stage, double share) const {
    return progress_(stage, share) ? absl::OkStatus() : absl::CancelledError("cancelled");
  }

  const EditableMap& base_;
  const UpdateDrives& drives_;
  const MapUpdateOptions& options_;
  const UpdateProgress& progress_;
  std::shared_ptr<const RadarMap> map_;
  Rig held_out_rig_;
  std::vector<Scan> held_out_scans_;
  JudgedUpdate result_;
};

}  // namespace

absl::StatusOr<JudgedUpdate> BuildUpdate(const EditableMap& base, const UpdateDrives& drives,
                                         const MapUpdateOptions& options,
                                         const UpdateProgress& progress) {
  return UpdateBuilder(base, drives, options, progress).Run();
}

std::string DescribeJudgement(const JudgedUpdate& update) {
  const SegmentEvaluation& whole = update.gate.whole;
  return absl::StrFormat("judged by %s: fit %.4f after %.4f, median error %.3f after %.3f m",
                         update.held_out, whole.new_version.fit, whole.old_version.fit,
                         whole.new_version.error_m, whole.old_version.error_m);
}

}  // namespace dcloc
