#include "client/cli/map/map_edit_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/output_file.h"
#include "client/cli/common/terminal.h"
#include "client/cli/map/map_files.h"
#include "client/cli/map/map_report.h"
#include "client/cli/map/region_options.h"
#include "core/map/map_edit.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct CutArguments {
  std::string file;
  RegionArguments region;
  std::string inside;   ///< the file to write with what lies in the region; empty: none
  std::string outside;  ///< likewise with what does not
  bool force = false;
  bool json = false;
};

struct MergeArguments {
  std::vector<std::string> files;
  std::string name;
  std::string out;
  bool is_same_frame = false;
  bool force = false;
  bool json = false;
};

std::string Dump(const ordered_json& json) {
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace);
}

void PrintFile(const std::string& file, const MapInfo& info) {
  absl::PrintF("%s: %d landmarks, %d keyframes over %.0f m of street, %s\n", Visible(file),
               info.point_count, info.keyframe_count, info.length_m,
               FormatBytes(static_cast<double>(info.size_bytes)));
}

absl::Status Cut(const CutArguments& arguments) {
  absl::Status status = CheckOutputFiles({{arguments.inside, arguments.outside}, arguments.force});
  if (!status.ok()) return status;
  const absl::StatusOr<EditableMap> map = ReadMapParts(arguments.file);
  if (!map.ok()) return map.status();
  const absl::StatusOr<PlanarRegion> region = RegionOf(arguments.region, *map);
  if (!region.ok()) return region.status();
  // Both before one is written, so that an error leaves no half of a split.
  std::vector<MadeFile> parts;
  std::vector<MapInfo> infos;
  for (const auto& [file, side] : {std::pair(arguments.inside, RegionSide::kInside),
                                   std::pair(arguments.outside, RegionSide::kOutside)}) {
    if (file.empty()) continue;
    const absl::StatusOr<EditableMap> part = KeepSide(*map, *region, side);
    if (!part.ok()) {
      return absl::Status(part.status().code(),
                          absl::StrCat(arguments.file, ": ", part.status().message()));
    }
    const absl::StatusOr<MapInfo> info =
        MakeMapFile(*part, parts.emplace_back(MadeFile{.file = file, .bytes = {}}));
    if (!info.ok()) return info.status();
    infos.push_back(*info);
  }
  status = WriteMadeFiles(parts, arguments.force);
  if (!status.ok()) return status;
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!arguments.json) PrintFile(parts[i].file, infos[i]);
    list.push_back({{"file", parts[i].file}, {"map", MapInfoJson(infos[i])}});
  }
  if (arguments.json) absl::PrintF("%s\n", Dump(list));
  return absl::OkStatus();
}

// Adds the map of `file` to `merged`, which is of `first_file`, and says in `list` what came of it.
absl::Status MergeFile(const std::string& file, const std::string& first_file, bool is_same_frame,
                       absl::StatusOr<EditableMap>& merged, ordered_json& list) {
  const absl::StatusOr<EditableMap> further = ReadMapParts(file);
  if (!further.ok()) return further.status();
  const absl::Status status = CheckFrames(*merged, *further, is_same_frame);
  if (!status.ok()) {
    return absl::Status(
        status.code(),
        absl::StrCat(file, ": ", status.message(), "; --same-frame says that both frames are one"));
  }
  if (!merged->Anchor() && further->Anchor()) {
    return absl::FailedPreconditionError(
        absl::StrCat(file, ": has an anchor on the Earth, and ", first_file,
                     " has none, whose frame is kept; name a map with an anchor first"));
  }
  MergeCounts counts;
  merged = Merge(*merged, *further, counts);
  if (!merged.ok()) {
    return absl::Status(merged.status().code(),
                        absl::StrCat(file, ": ", merged.status().message()));
  }
  if (counts.doubled_landmarks > 0) {
    absl::FPrintF(stderr,
                  "%s: %d landmarks lie within 0.4 m of others; where drives of two maps saw the "
                  "same street, `dcloc map survey` of the drives fuses them\n",
                  Visible(file), counts.doubled_landmarks);
  }
  list.push_back({{"file", file},
                  {"shared_keyframe_count", counts.shared_keyframes},
                  {"shared_landmark_count", counts.shared_landmarks},
                  {"doubled_landmark_count", counts.doubled_landmarks}});
  return absl::OkStatus();
}

absl::Status MergeFiles(const MergeArguments& arguments) {
  absl::Status status = CheckOutputFiles({{arguments.out}, arguments.force});
  if (!status.ok()) return status;
  absl::StatusOr<EditableMap> merged = ReadMapParts(arguments.files.front());
  if (!merged.ok()) return merged.status();
  ordered_json list = ordered_json::array();
  for (std::size_t i = 1; i < arguments.files.size(); ++i) {
    status = MergeFile(arguments.files[i], arguments.files.front(), arguments.is_same_frame, merged,
                       list);
    if (!status.ok()) return status;
  }
  if (!arguments.name.empty()) merged->name = arguments.name;
  const absl::StatusOr<MapInfo> info = WriteMapParts(*merged, arguments.out);
  if (!info.ok()) return info.status();
  if (arguments.json) {
    absl::PrintF("%s\n",
                 Dump({{"file", arguments.out}, {"map", MapInfoJson(*info)}, {"merged", list}}));
  } else {
    PrintFile(arguments.out, *info);
  }
  return absl::OkStatus();
}

// What crop, remove and split have in common.
CLI::App* AddCut(CLI::App& map, const std::string& name, const std::string& description,
                 const std::shared_ptr<CutArguments>& arguments, int& exit_code) {
  CLI::App* app = map.add_subcommand(name, description);
  app->add_option("file", arguments->file, "Map file")->required()->type_name("FILE");
  AddRegionOptions(*app, arguments->region);
  AddForceOption(*app, arguments->force);
  app->add_flag("--json", arguments->json, "Print what was written as JSON");
  OnRun(*app, arguments, exit_code, &Cut);
  return app;
}

void AddCrop(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<CutArguments>();
  CLI::App* crop = AddCut(map, "crop", "Keep a region of a map", arguments, exit_code);
  crop->add_option("--out", arguments->inside, "Map file to write")->required()->type_name("FILE");
  crop->footer(
      "Frame, anchor and landmarks stay as they are. A keyframe outside of the region stays where\n"
      "landmarks inside belong to it.\n"
      "Example, 400 m of street, and a district that was drawn in a GIS:\n"
      "  dcloc map crop town.dclm --box 0,-100,400,100 --out part.dclm\n"
      "  dcloc map crop town.dclm --region district.geojson --out district.dclm");
}

void AddRemove(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<CutArguments>();
  CLI::App* remove =
      AddCut(map, "remove", "Take a region out of a map, such as a construction site", arguments,
             exit_code);
  remove->add_option("--out", arguments->outside, "Map file to write")
      ->required()
      ->type_name("FILE");
  remove->footer(
      "Example:\n"
      "  dcloc map remove town.dclm --polygon 120,5,180,5,180,30,120,30 --out open.dclm");
}

void AddSplit(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<CutArguments>();
  CLI::App* split =
      AddCut(map, "split", "Make two maps of one: a region, and the rest", arguments, exit_code);
  split->add_option("--inside", arguments->inside, "Map file to write with the region")
      ->required()
      ->type_name("FILE");
  split->add_option("--outside", arguments->outside, "Map file to write with the rest")
      ->required()
      ->type_name("FILE");
  split->footer(
      "Both parts, merged, are the map again.\n"
      "Example:\n"
      "  dcloc map split town.dclm --box -1000,-1000,500,1000 --inside west.dclm --outside "
      "east.dclm");
}

void AddMerge(CLI::App& map, int& exit_code) {
  auto arguments = std::make_shared<MergeArguments>();
  CLI::App* merge = map.add_subcommand("merge", "Make one map of several");
  merge->add_option("files", arguments->files, "Map files; the first one's frame is kept")
      ->required()
      ->expected(2, 1000)
      ->type_name("FILE");
  merge->add_option("--out", arguments->out, "Map file to write")->required()->type_name("FILE");
  merge->add_option("--name", arguments->name, "Name of the map; the first one's by default");
  merge->add_flag("--same-frame", arguments->is_same_frame,
                  "The maps are in one frame, as parts of a map are; without it they need anchors");
  AddForceOption(*merge, arguments->force);
  merge->add_flag("--json", arguments->json, "Print what was written as JSON");
  merge->footer(
      "Anchors tie the frames together; the first map's is kept. What parts of one map share comes "
      "once. Landmarks of\n"
      "different drives over the same street are not fused: survey the drives for that.\n"
      "Example:\n"
      "  dcloc map merge west.dclm east.dclm --same-frame --out town.dclm");
  OnRun(*merge, arguments, exit_code, &MergeFiles);
}

}  // namespace

void AddMapEditCommands(CLI::App& map_command, int& exit_code) {
  AddCrop(map_command, exit_code);
  AddRemove(map_command, exit_code);
  AddSplit(map_command, exit_code);
  AddMerge(map_command, exit_code);
}

}  // namespace dcloc::cli
