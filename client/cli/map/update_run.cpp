#include "client/cli/map/update_run.h"

#include <algorithm>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/output_file.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/map_files.h"
#include "client/cli/map/stage_line.h"
#include "client/cli/map/update_report.h"
#include "core/update/update_gate.h"

namespace dcloc::cli {
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

/// One command's work. Drives are read one at a time; of each only what an update needs is kept.
class UpdateRun {
 public:
  explicit UpdateRun(const UpdateArguments& arguments) : arguments_(arguments) {}

  absl::Status Run() {
    absl::Status status = Open();
    if (status.ok()) status = PlacePasses();
    if (!status.ok()) return status;
    line_.Update("updating the map", 0.0);
    auto update = UpdateMap(base_, report_.passes, arguments_.options);
    if (!update.ok()) return update.status();
    report_.update = *std::move(update);
    Describe();
    line_.Update("judging the new version", 0.0);
    auto gate = EvaluateUpdate(base_, report_.update.map, held_out_rig_, held_out_scans_);
    if (!gate.ok()) {
      return absl::Status(gate.status().code(),
                          absl::StrCat(report_.held_out, ": ", gate.status().message()));
    }
    report_.gate = *std::move(gate);
    return WriteAll();
  }

 private:
  absl::Status Open() {
    report_.base = arguments_.base;
    report_.held_out = arguments_.held_out.empty() ? arguments_.drives.back() : arguments_.held_out;
    if (std::ranges::find(arguments_.drives, report_.held_out) == arguments_.drives.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--keep-out is ", report_.held_out, "; it must be one of --drive"));
    }
    if (arguments_.drives.size() < 3) {
      return absl::InvalidArgumentError(
          "an update needs three drives at least: two that agree, and one that is kept out");
    }
    std::set<std::string> names;
    for (const std::string& name : arguments_.drives) {
      if (names.insert(name).second) continue;
      return absl::InvalidArgumentError(absl::StrCat("--drive names ", name, " twice"));
    }
    if (arguments_.out == arguments_.report) {
      return absl::InvalidArgumentError(
          absl::StrCat("--out and --report are both ", arguments_.out));
    }
    absl::Status status = CheckOutputFiles({{arguments_.out, arguments_.report}, arguments_.force});
    status.Update(CheckFolders({arguments_.out, arguments_.report}));
    if (!status.ok()) return status;
    auto base = ReadMapParts(arguments_.base);
    if (!base.ok()) return base.status();
    base_ = *std::move(base);
    auto bytes = ToMapBytes(base_);
    if (!bytes.ok()) return bytes.status();
    auto map = RadarMap::FromBytes(*std::move(bytes));
    if (!map.ok()) return map.status();
    map_ = *std::move(map);
    return absl::OkStatus();
  }

  absl::Status PlacePasses() {
    for (const std::string& name : arguments_.drives) {
      DriveRequest request = arguments_.request;
      request.name = name;
      const absl::StatusOr<Drive> drive = ReadDrive(arguments_.dataset, request);
      if (!drive.ok()) return drive.status();
      if (absl::Status status = CheckRadarsOfScans(*drive); !status.ok()) return status;
      const absl::Status status = name == report_.held_out ? HoldOut(*drive) : Place(*drive);
      if (!status.ok()) return status;
    }
    const auto useful = std::ranges::count(report_.faults, std::string());
    if (useful >= 2) return absl::OkStatus();
    std::vector<std::string> why;
    for (std::size_t i = 0; i < report_.passes.size(); ++i) {
      if (!report_.faults[i].empty()) {
        why.push_back(absl::StrCat(report_.passes[i].name, ": ", report_.faults[i]));
      }
    }
    return absl::FailedPreconditionError(absl::StrCat("two drives must agree on a change, and ",
                                                      useful, " is of use. ",
                                                      absl::StrJoin(why, "; ")));
  }

  absl::Status HoldOut(const Drive& drive) {
    held_out_rig_ = drive.rig;
    for (const DriveScan& entry : drive.scans) held_out_scans_.push_back(entry.scan);
    return absl::OkStatus();
  }

  absl::Status Place(const Drive& drive) {
    auto placer = PassPlacer::Create(map_, drive.name, VehicleOf(drive.rig), drive.rig);
    if (!placer.ok()) return placer.status();
    for (std::size_t i = 0; i < drive.scans.size(); ++i) {
      placer->Add(drive.scans[i].scan);
      line_.Update(absl::StrCat("localizing ", drive.name),
                   static_cast<double>(i + 1) / static_cast<double>(drive.scans.size()));
    }
    PlacedPass pass = std::move(*placer).Finish();
    report_.faults.push_back(FaultOf(pass));
    if (!report_.faults.back().empty()) {
      for (PlacedScan& scan : pass.scans) scan.is_good = false;
    }
    report_.passes.push_back(std::move(pass));
    return absl::OkStatus();
  }

  void Describe() {
    std::vector<std::string> names;
    for (const std::size_t i : report_.update.order) names.push_back(report_.passes[i].name);
    report_.update.map.description =
        absl::StrCat("dcloc map update: ", arguments_.dataset.format, " ",
                     absl::StrJoin(names, ", "), "; judged by ", report_.held_out);
    for (PlacedPass& pass : report_.passes) {
      for (PlacedScan& scan : pass.scans) scan.points = {};
    }
  }

  absl::Status WriteAll() {
    const StopSignals stop;  // not between a file and its page
    absl::Status status;
    if (report_.gate.is_better) {
      EditableMap& map = report_.update.map;
      absl::StrAppendFormat(
          &map.description, ": fit %.4f after %.4f, median error %.3f after %.3f m",
          report_.gate.whole.new_version.fit, report_.gate.whole.old_version.fit,
          report_.gate.whole.new_version.error_m, report_.gate.whole.old_version.error_m);
      const auto info = WriteMapParts(map, arguments_.out);
      status = info.status();
      if (status.ok()) report_.out = arguments_.out;
    } else {
      status = absl::FailedPreconditionError(
          absl::StrCat(arguments_.out, " is not written: ", report_.gate.reason));
    }
    if (!arguments_.report.empty()) {
      const std::string page = UpdateHtml(report_);
      status.Update(WriteFileAtomically(arguments_.report, std::as_bytes(std::span(page))));
    }
    absl::PrintF("%s", arguments_.json ? UpdateJson(report_).dump(2) + "\n" : UpdateText(report_));
    return status;
  }

  const UpdateArguments& arguments_;
  StageLine line_;
  EditableMap base_;
  std::shared_ptr<const RadarMap> map_;
  Rig held_out_rig_;
  std::vector<Scan> held_out_scans_;
  UpdateReport report_;
};

}  // namespace

absl::Status RunUpdate(const UpdateArguments& arguments) { return UpdateRun(arguments).Run(); }

}  // namespace dcloc::cli
