#include "client/cli/map/map_diff_command.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/atomic_file.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/output_file.h"
#include "client/cli/map/map_files.h"
#include "client/evaluation/map_diff_picture.h"
#include "core/map/map_diff.h"
#include "core/map/map_edit.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct DiffArguments {
  std::string old_file;
  std::string new_file;
  MapDiffOptions options;
  std::string picture;
  bool is_same_frame = false;
  bool force = false;
  bool json = false;
};

ordered_json ChangeJson(const LandmarkChange& landmark) {
  return {{"x_m", landmark.p_map.x()},         {"y_m", landmark.p_map.y()},
          {"z_m", landmark.p_map.z()},         {"rcs_dbsm", landmark.rcs_dbsm},
          {"scan_count", landmark.scan_count}, {"pass_count", landmark.pass_count}};
}

ordered_json ChangesJson(const std::vector<LandmarkChange>& landmarks) {
  ordered_json list = ordered_json::array();
  for (const LandmarkChange& landmark : landmarks) list.push_back(ChangeJson(landmark));
  return list;
}

ordered_json DiffJson(const DiffArguments& arguments, const MapDiff& diff) {
  ordered_json moved = ordered_json::array();
  for (const auto& [before, after] : diff.moved) {
    moved.push_back({{"from", ChangeJson(before)}, {"to", ChangeJson(after)}});
  }
  return {{"old", arguments.old_file},
          {"new", arguments.new_file},
          {"same_count", diff.same.size()},
          {"same_rms_m", diff.same_rms_m},
          {"only_old_covers_count", diff.only_old_covers_count},
          {"only_new_covers_count", diff.only_new_covers_count},
          {"came", ChangesJson(diff.added)},
          {"went", ChangesJson(diff.removed)},
          {"moved", moved}};
}

std::string DiffText(const MapDiff& diff) {
  return absl::StrFormat(
      "same         %d landmarks, %.3f m apart (rms)\n"
      "came         %d\n"
      "went         %d\n"
      "moved        %d\n"
      "not covered  %d of the old map, %d of the new one\n",
      diff.same.size(), diff.same_rms_m, diff.added.size(), diff.removed.size(), diff.moved.size(),
      diff.only_old_covers_count, diff.only_new_covers_count);
}

absl::Status Draw(const MapDiff& diff, const std::string& file) {
  if (file.empty()) return absl::OkStatus();
  const Picture picture = DrawMapDiff(diff);
  if (absl::EndsWith(file, ".png")) return RenderPng(picture, file);
  const absl::StatusOr<std::string> svg = RenderSvg(picture);
  if (!svg.ok()) return svg.status();
  return WriteFileAtomically(file, std::as_bytes(std::span(*svg)));
}

absl::Status CompareFiles(const DiffArguments& arguments) {
  absl::Status status = Validate(arguments.options);
  if (status.ok()) status = CheckOutputFiles({{arguments.picture}, arguments.force});
  if (!status.ok()) return status;
  const absl::StatusOr<EditableMap> before = ReadMapParts(arguments.old_file);
  if (!before.ok()) return before.status();
  const absl::StatusOr<EditableMap> after = ReadMapParts(arguments.new_file);
  if (!after.ok()) return after.status();
  const bool is_same_frame = arguments.is_same_frame || (!before->Anchor() && !after->Anchor());
  if (status = CheckFrames(*before, *after, is_same_frame); !status.ok()) {
    return absl::Status(status.code(), absl::StrCat(arguments.new_file, ": ", status.message(),
                                                    "; --same-frame says that both are one"));
  }
  const absl::StatusOr<MapDiff> diff = Compare(*before, *after, arguments.options);
  if (!diff.ok()) return diff.status();
  if (status = Draw(*diff, arguments.picture); !status.ok()) return status;
  absl::PrintF(
      "%s",
      arguments.json
          ? DiffJson(arguments, *diff).dump(2, ' ', false, ordered_json::error_handler_t::replace) +
                "\n"
          : DiffText(*diff));
  return absl::OkStatus();
}

std::string CheckPicture(const std::string& file) {
  if (absl::EndsWith(file, ".png") || absl::EndsWith(file, ".svg")) return "";
  return "must end with .svg or .png";
}

}  // namespace

void AddMapDiffCommand(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<DiffArguments>();
  MapDiffOptions& options = arguments->options;
  CLI::App* diff = map_command.add_subcommand(
      "diff", "Compare two maps of a place: landmarks that came, went or moved");
  diff->add_option("old", arguments->old_file, "The earlier map file")
      ->required()
      ->type_name("OLD");
  diff->add_option("new", arguments->new_file, "The later map file")->required()->type_name("NEW");
  diff->add_option("--same-m", options.same_m, "Landmarks nearer than this are one")
      ->type_name("M")
      ->capture_default_str();
  diff->add_option("--moved-m", options.moved_m, "Of the others, pairs nearer than this have moved")
      ->type_name("M")
      ->capture_default_str();
  diff->add_option("--covered-m", options.covered_m,
                   "Only where both maps have a keyframe within this distance")
      ->type_name("M")
      ->capture_default_str();
  diff->add_flag("--same-frame", arguments->is_same_frame,
                 "The maps are in one frame, though only one of them has an anchor");
  diff->add_option("--picture", arguments->picture, "A picture to write (needs gnuplot)")
      ->check(CheckPicture)
      ->type_name("SVG|PNG");
  AddForceOption(*diff, arguments->force);
  diff->add_flag("--json", arguments->json, "Print as JSON, each landmark with its place");
  diff->footer(
      "Anchors tie the frames together; maps without anchors are taken to share one.\n"
      "Maps of different drives differ also by what one drive saw and the other missed.\n"
      "Example:\n"
      "  dcloc map diff may.dclm june.dclm --picture changes.svg --json");
  OnRun(*diff, arguments, exit_code, &CompareFiles);
}

}  // namespace dcloc::cli
