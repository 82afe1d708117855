#include "client/cli/map/map_align_command.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/anchor_option.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/output_file.h"
#include "client/cli/common/stage_line.h"
#include "client/cli/map/control_point_file.h"
#include "client/cli/map/map_files.h"
#include "client/cli/map/map_report.h"
#include "core/map/map_frame.h"
#include "core/mapping/map_alignment.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct AlignArguments {
  std::string file;
  std::string control;
  std::string to;
  std::optional<GeodeticAnchor> anchor;
  std::string out;
  bool force = false;
  bool json = false;
};

/// The aligned map, and what is told of it.
struct Aligned {
  EditableMap map;
  ordered_json json;
  std::string text;
};

absl::StatusOr<Aligned> Tied(const EditableMap& map, const GeodeticAnchor& anchor) {
  absl::StatusOr<EditableMap> tied = MoveTo(map, Pose3(), anchor);
  if (!tied.ok()) return tied.status();
  return Aligned{.map = *std::move(tied), .json = ordered_json::object(), .text = ""};
}

absl::StatusOr<Aligned> ByControlPoints(const EditableMap& map, const std::string& file) {
  const auto points = ReadControlPoints(file);
  if (!points.ok()) return points.status();
  const absl::StatusOr<ControlFit> fit = FitAnchor(*points);
  if (!fit.ok()) {
    return absl::Status(fit.status().code(), absl::StrCat(file, ": ", fit.status().message()));
  }
  absl::StatusOr<Aligned> aligned = Tied(map, fit->anchor);
  if (!aligned.ok()) return aligned;
  aligned->json["control_points"] = ordered_json::array();
  for (std::size_t i = 0; i < points->size(); ++i) {
    ordered_json point = {{"residual_m", fit->residual_m[i]}, {"left_out_m", nullptr}};
    if (!fit->left_out_m.empty()) point["left_out_m"] = fit->left_out_m[i];
    aligned->json["control_points"].push_back(point);
    absl::StrAppendFormat(&aligned->text, "point %-6d %.3f m off", i + 1, fit->residual_m[i]);
    if (!fit->left_out_m.empty()) {
      absl::StrAppendFormat(&aligned->text, ", %.3f m where the others put it", fit->left_out_m[i]);
    }
    aligned->text += "\n";
  }
  return aligned;
}

absl::StatusOr<Aligned> ToMap(const EditableMap& map, const std::string& to_file) {
  const auto from_bytes = ToMapBytes(map);
  if (!from_bytes.ok()) return from_bytes.status();
  const auto from = RadarMap::FromBytes(*from_bytes);
  if (!from.ok()) return from.status();
  const absl::StatusOr<EditableMap> to_parts = ReadMapParts(to_file);
  if (!to_parts.ok()) return to_parts.status();
  const auto to = RadarMap::Open(to_file);
  if (!to.ok()) return to.status();
  StageLine line;
  const absl::StatusOr<MapAlignment> found = AlignMaps(**from, **to, [&](double share) {
    line.Update("looking for one map in the other", share);
    return true;
  });
  if (!found.ok()) return found.status();
  absl::StatusOr<EditableMap> moved = MoveTo(map, found->T_to_from, to_parts->Anchor());
  if (!moved.ok()) return moved.status();
  const Eigen::Vector3d& t = found->T_to_from.translation_m;
  const double yaw_deg = Yaw(found->T_to_from.rotation) / kRadPerDeg;
  return Aligned{
      .map = *std::move(moved),
      .json = {{"place_count", found->pair_count},
               {"rms_m", found->rms_m},
               {"shift_m", {t.x(), t.y(), t.z()}},
               {"turn_deg", yaw_deg}},
      .text = absl::StrFormat("moved        (%.2f, %.2f, %.2f) m and %.3f deg\n"
                              "agreement    %.3f m (rms) at %d places\n",
                              t.x(), t.y(), t.z(), yaw_deg, found->rms_m, found->pair_count)};
}

absl::StatusOr<Aligned> Align(const EditableMap& map, const AlignArguments& arguments) {
  if (!arguments.to.empty()) return ToMap(map, arguments.to);
  if (!arguments.control.empty()) return ByControlPoints(map, arguments.control);
  return Tied(map, *arguments.anchor);
}

absl::Status AlignFile(const AlignArguments& arguments) {
  absl::Status status = CheckOutputFiles({{arguments.out}, arguments.force});
  status.Update(CheckFolders({arguments.out}));
  if (!status.ok()) return status;
  const absl::StatusOr<EditableMap> map = ReadMapParts(arguments.file);
  if (!map.ok()) return map.status();
  absl::StatusOr<Aligned> aligned = Align(*map, arguments);
  if (!aligned.ok()) return aligned.status();
  const absl::StatusOr<MapInfo> info = WriteMapParts(aligned->map, arguments.out);
  if (!info.ok()) return info.status();
  if (arguments.json) {
    aligned->json["map"] = MapInfoJson(*info);
    absl::PrintF("%s\n", aligned->json.dump(2));
  } else {
    absl::PrintF("%s%s", aligned->text, MapInfoText(*info));
  }
  return absl::OkStatus();
}

}  // namespace

void AddMapAlignCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<AlignArguments>();
  CLI::App* app = map_command.add_subcommand(
      "align", "Tie a map to the Earth, or bring it into another's frame");
  app->add_option("file", arguments->file, "Map file")->required()->type_name("FILE");
  CLI::Option_group* how = app->add_option_group("how", "Exactly one of them");
  how->add_option("--control", arguments->control,
                  "Places that are known in the map and on the Earth: lines of "
                  "x_m,y_m,latitude_deg,longitude_deg[,height_m] behind such a header")
      ->type_name("CSV");
  how->add_option("--to", arguments->to, "A map that shows some of the same ground")
      ->type_name("FILE");
  AddAnchorOption(*how, arguments->anchor);
  how->require_option(1);
  app->add_option("--out", arguments->out, "Map file to write")->required()->type_name("FILE");
  AddForceOption(*app, arguments->force);
  app->add_flag("--json", arguments->json, "Print as JSON");
  app->footer(
      "Landmarks do not move to one another: a map that is bent stays so, and the residuals tell.\n"
      "Examples, of a survey without position fixes:\n"
      "  dcloc map align survey.dclm --control points.csv --out town.dclm\n"
      "  dcloc map align east.dclm --to town.dclm --out east-in-town.dclm\n"
      "  dcloc map merge town.dclm east-in-town.dclm --same-frame --out both.dclm");
  OnRun(*app, arguments, exit_code, &AlignFile);
}

}  // namespace dcloc::cli
